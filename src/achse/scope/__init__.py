"""The scope: channels, triggers, rings of samples, recordings and their forms.

It knows neither ADS nor loop nor clock; `achse.devices.scope` serves it, `achse.client` and the
command line read its forms.
"""

from achse.scope.channel import ScopeChannel, channel_of
from achse.scope.channel_group import ScopeSource
from achse.scope.data import ScopeBlock, ScopeData, ScopeTrack
from achse.scope.definition import ScopeDefinition, definition_of, parse_definition
from achse.scope.recorder import Recorder, ScopeState
from achse.scope.trigger import TRIGGER_KINDS, ScopeTrigger, trigger_of
from achse.scope.types import SCOPE_TYPES, ScopeError, ScopeType, type_of_number, type_of_words

__all__ = [
    "SCOPE_TYPES",
    "TRIGGER_KINDS",
    "Recorder",
    "ScopeBlock",
    "ScopeChannel",
    "ScopeData",
    "ScopeDefinition",
    "ScopeError",
    "ScopeSource",
    "ScopeState",
    "ScopeTrack",
    "ScopeTrigger",
    "ScopeType",
    "channel_of",
    "definition_of",
    "parse_definition",
    "trigger_of",
    "type_of_number",
    "type_of_words",
]
