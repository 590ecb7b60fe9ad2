"""Notebooks as pages: their Markdown, code, printed output and pictures, without running them."""

import base64
import json
import re
from pathlib import Path
from typing import Any

#: links of a notebook in docs/, as its page in docs/generated has them
_ABOVE = re.compile(r"\]\((?!\w+:|#|/)")


def page(notebook: Path, pictures: Path) -> str:
    """Markdown of a notebook; its pictures are written into a folder next to the page."""
    data = json.loads(notebook.read_text(encoding="utf-8"))
    parts: list[str] = []
    for number, one in enumerate(data["cells"]):
        text = "".join(one["source"])
        if one["cell_type"] == "markdown":
            parts.append(_ABOVE.sub(r"](../", text))
        elif one["cell_type"] == "code" and text.strip():
            parts.append(f"```python\n{text}\n```")
            parts += _outputs(one.get("outputs", []), pictures, f"{notebook.stem}-{number}")
    return "\n\n".join(parts) + "\n"


def _outputs(outputs: list[dict[str, Any]], pictures: Path, name: str) -> list[str]:
    parts = []
    for number, one in enumerate(outputs):
        data = one.get("data", {})
        text = "".join(one.get("text", data.get("text/plain", [])))
        if "image/png" in data:
            pictures.mkdir(parents=True, exist_ok=True)
            path = pictures / f"{name}-{number}.png"
            path.write_bytes(base64.b64decode("".join(data["image/png"])))
            parts.append(f"![output]({pictures.name}/{path.name})")
        elif text.strip():
            parts.append(f"```text\n{text.rstrip()}\n```")
    return parts
