from pathlib import Path

import pytest


@pytest.fixture
def achse_config():
    return Path(__file__).with_name("station.toml")
