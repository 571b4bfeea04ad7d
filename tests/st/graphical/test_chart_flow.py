"""Flow of charts: what each transition leaves and activates."""

from achse.st.graphical.chart_flow import ChartFlow
from achse.st.graphical.charts import read_chart
from tests.st.graphical.drawings import branch, chart, jump, macro, segment, step, transition


def flow(*elements: str) -> list[str]:
    """`left -condition-> activated` of each transition."""
    flow_of_chart = ChartFlow(read_chart(chart(*elements)))
    return [
        f"{' '.join(one.name for one in firing.left)} -{firing.transition.text}-> "
        + " ".join(one.name for one in firing.activated)
        for firing in flow_of_chart.firings
    ]


def test_alternatives_nest_and_run_on_behind_the_branch() -> None:
    firings = flow(
        step("A", initial="TRUE"),
        branch(
            segment(transition("a"), step("B"), transition("b")),
            segment(branch(segment(transition("c")), segment(transition("d"), jump("A")))),
        ),
        step("C"),
        transition("e"),
        jump("B"),
    )
    assert firings == ["A -a-> B", "B -b-> C", "A -c-> C", "A -d-> A", "C -e-> B"]


def test_segments_of_a_parallel_branch_begin_and_end_together() -> None:
    firings = flow(
        step("A", initial="TRUE"),
        transition("a"),
        branch(
            segment(step("B"), transition("b"), step("C")),
            segment(macro(step("D"))),
            parallel=True,
            name="both",
        ),
        branch(segment(transition("c"), jump("BOTH")), segment(transition("d"), jump("A"))),
    )
    assert firings == ["A -a-> B D", "B -b-> C", "C D -c-> B D", "C D -d-> A"]


def test_a_chart_without_a_jump_stays_in_its_last_step() -> None:
    assert flow(step("A", initial="TRUE"), transition("a"), step("B")) == ["A -a-> B"]
