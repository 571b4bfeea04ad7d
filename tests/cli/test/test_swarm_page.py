"""The page of a replay: one file with charts, acts and the end; nothing in it is read as markup."""

import json
import re

from achse.cli.test.swarm_page import page_of
from achse.motion import AxisParameters, Nc
from achse.swarm.track import Track


def test_page_holds_track_acts_and_end() -> None:
    track = Track()
    nc = Nc(2_000_000, [AxisParameters(1, "</script>X"), AxisParameters(2, "Y")])
    for cycle in range(3):
        track.take(cycle * 2_000_000, nc)
    page = page_of("Seed 7", "a < b", wrong=True, acts=["0.1 s <dial>", "0.2 s"], track=track)
    match = re.search(r'<script type="application/json" id="track">(.*?)</script>', page, re.DOTALL)
    assert match is not None
    document = json.loads(match[1])
    assert document["names"] == ["</script>X", "Y"]
    assert document["columns"][0] == [0.0, 0.002, 0.004]
    assert len(document["columns"]) == 7
    assert '<p class="wrong">a &lt; b</p>' in page
    assert "0.1 s &lt;dial&gt;\n0.2 s" in page
    assert page.count("</script>") == 2
    assert "export default" not in page
