"""Result paths that cases from before still have, and what they are called now."""

_TORQUE, _FORCE, _BODY = "isolation/torque_reaction", "isolation/support_force", "isolation/body"
RENAMED = {
    f"{_TORQUE}/translation": f"{_BODY}/translation_harmonics",
    f"{_TORQUE}/rotation": f"{_BODY}/rotation_harmonics",
    f"{_TORQUE}/support_force": f"{_FORCE}/steady_harmonics",
    f"{_TORQUE}/support_force_peak": f"{_FORCE}/steady_peak",
    f"{_TORQUE}/mean_support_force": f"{_FORCE}/mean",
    f"{_TORQUE}/largest_load": f"{_FORCE}/largest_load",
    f"{_TORQUE}/minimum_load": f"{_FORCE}/minimum_load",
    "foundation/coupled/machine/translation": f"{_BODY}/translation_harmonics",
    "foundation/coupled/machine/rotation": f"{_BODY}/rotation_harmonics",
    "foundation/coupled/mount_force": f"{_FORCE}/steady_harmonics",
}


def current_path(path: str) -> str:
    """The path under which a result is found now."""
    return RENAMED.get(path, path)
