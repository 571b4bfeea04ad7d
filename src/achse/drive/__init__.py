"""The virtual CiA 402 servo drive: objects, process data and a step, with no bus inside."""
