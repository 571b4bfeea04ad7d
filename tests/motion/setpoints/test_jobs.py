"""Jobs: what one asks for is all that another takes over."""

from math import inf

from achse.codes.axis import BufferMode, StartType
from achse.motion.fields.job import JobProgress, JobRequest
from achse.motion.record import JOB
from achse.motion.setpoints.jobs import copy_request, set_request
from achse.native.declare import plain_record

Job = plain_record(JOB)


def test_a_job_has_its_arguments_and_nothing_else() -> None:
    job = Job()
    job.start_velocity, job.blending_position, job.mode = 3.0, 4.0, BufferMode.BUFFERED
    set_request(job, 7, StartType.RELATIVE, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0)
    options = {name: getattr(job, name) for name in JobRequest.__annotations__}
    assert options == {
        "number": 7, "start_type": StartType.RELATIVE, "mode": BufferMode.ABORTING,
        "position": 1.0, "velocity": 2.0, "acceleration": 3.0, "deceleration": 4.0, "jerk": 5.0,
        "end_velocity": 6.0, "start_velocity": 0.0, "blending_position": inf,
    }  # fmt: skip


def test_all_of_the_request_is_taken_over_and_no_progress() -> None:
    job, other = Job(), Job()
    for number, name in enumerate(JOB.fields, 1):
        setattr(other, name, number)
    copy_request(job, other)
    for name in JobRequest.__annotations__:
        assert getattr(job, name) == getattr(other, name), name
    for name in JobProgress.__annotations__:
        assert getattr(job, name) == JOB.fields[name].default, name
