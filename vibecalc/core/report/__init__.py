"""Reports: text, JSON and pictures from results, nothing recomputed."""
