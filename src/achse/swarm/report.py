"""A failure for people: seed and commit, and a test of a few lines that is kept."""

import json
import pprint
import shlex
import subprocess
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path

from achse.swarm.outcome import BrokenInvariant
from achse.swarm.worlds.world import World


def commit() -> str:
    """Return the commit of this source, or the version where there is no git."""
    folder = Path(__file__).parent
    try:
        result = subprocess.run(
            ["git", "-C", str(folder), "rev-parse", "--short=12", "HEAD"],
            capture_output=True,
            text=True,
            timeout=5,
            check=True,
        )
    except (OSError, subprocess.SubprocessError):
        return version("achse")
    return result.stdout.strip()


def failure_lines(
    seed: int,
    violation: BrokenInvariant,
    project: str = "",
    invariants: str = "",
    *,
    motion: bool = False,
    plans: bool = False,
) -> list[str]:
    """Return what is printed of a failure, with the command that shows it again."""
    words = ["achse", "swarm", *([project] if project else []), "--seed", str(seed), "--replay"]
    words += ["--motion"] if motion else []
    words += ["--plans"] if plans else []
    words += ["--invariants", invariants] if invariants else []
    return [f"seed {seed} commit {commit()} failed: {violation}", f"  {shlex.join(words)}"]


def source_of_test(world: World, violation: BrokenInvariant, invariants: str = "") -> str:
    """Return a test in Python that plays this world, with the invariants of a user's file."""
    document = json.loads(world.encode())
    acts = ",\n        ".join(json.dumps(asdict(act)) for act in world.acts)
    document["acts"] = []
    body = pprint.pformat(document, width=96, sort_dicts=False)
    acts = acts.replace("true", "True").replace("false", "False").replace("null", "None")
    body = body.replace("'acts': []", f"'acts': [\n        {acts}\n    ]")
    name = violation.invariant.replace("-", "_")
    more = "from achse.swarm.project import load_checks\n" if invariants else ""
    path = "from pathlib import Path\n" if invariants else ""
    checks = f", checks=load_checks(Path({invariants!r}))" if invariants else ""
    return f'''"""Found by achse swarm, seed {world.seed}, commit {commit()}."""

import json
{path}
from achse.swarm.play import play
{more}from achse.swarm.worlds.world import World

WORLD = {body}
"""{violation.what.splitlines()[0][:150]}"""


def test_{name}_holds() -> None:
    assert play(World.decode(json.dumps(WORLD)){checks}).violation is None
'''
