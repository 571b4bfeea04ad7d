"""The page of a replay: set points of all axes over time, and the acts, for a browser.

It is one file, the charts in it are those of the pages of a station (`achse.web`).
"""

import html
import json
from collections.abc import Sequence
from importlib.resources import files

from achse.swarm.track import Track

_QUANTITIES = ("position", "velocity", "acceleration")

_PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>{title}</title>
<style>{style}
body {{ font: 14px sans-serif; margin: 1em; max-width: 80em }}
.wrong {{ color: #a00; font-weight: bold }}
pre {{ max-height: 30em; overflow: auto; border: 1px solid #ccc; padding: 0.5em }}
</style></head><body>
<h1>{title}</h1>
<p class="{kind}">{end}</p>
<div id="charts"></div>
<h2>Acts</h2>
<pre>{acts}</pre>
<script type="application/json" id="track">{track}</script>
<script type="module">
{script}
const track = JSON.parse(document.getElementById("track").textContent);
const colours = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#999999"];
track.quantities.forEach((quantity, n) => new uPlot({{
  title: quantity, width: Math.min(window.innerWidth - 40, 1250), height: 240,
  cursor: {{sync: {{key: "track"}}}}, scales: {{x: {{time: false}}}},
  series: [{{label: "s"}}, ...track.names.map((name, axis) =>
    ({{label: name, stroke: colours[axis % colours.length]}}))],
}}, [track.columns[0], ...track.names.map((_, axis) => track.columns[1 + 3 * axis + n])],
  document.getElementById("charts")));
</script></body></html>
"""


def page_of(title: str, end: str, *, wrong: bool, acts: Sequence[str], track: Track) -> str:
    """Return the page of a world that was played."""
    vendor = files("achse.web") / "pages" / "vendor"
    script, _, _ = (vendor / "uPlot.js").read_text(encoding="utf-8").rpartition("export")
    document = {"names": track.names, "quantities": _QUANTITIES, "columns": track.columns()}
    text = json.dumps(document, allow_nan=False, separators=(",", ":"))
    return _PAGE.format(
        title=html.escape(title),
        end=html.escape(end),
        kind="wrong" if wrong else "holds",
        acts=html.escape("\n".join(acts)),
        track=text.replace("<", "\\u003c"),
        style=(vendor / "uPlot.min.css").read_text(encoding="utf-8"),
        script=script,
    )
