"""The registry of surrogates: every kind of the configuration is known, and nothing else is opened or trained."""

from typing import get_args

import pytest
import torch

from millprint.config.surrogate import VariantConfig
from millprint.errors import ConfigError
from millprint.surrogate.checkpoint import write_tensors
from millprint.surrogate.kinds import KINDS, kind_of, open_surrogate
from millprint.surrogate.protocol import Setting
from tests.unit.surrogate_samples import CONTACTS


def test_the_registry_has_the_kinds_of_the_configuration():
    assert list(KINDS) == list(get_args(VariantConfig.model_fields["kind"].annotation))
    assert len({kind.title for kind in KINDS.values()}) == len(KINDS)


def test_an_unknown_kind_is_refused(tmp_path):
    with pytest.raises(ConfigError, match="unknown kind of surrogate: spectral; known: graph, contact"):
        kind_of("spectral")
    write_tensors(tmp_path / "weights.pt", {"kind": "spectral"})
    with pytest.raises(ConfigError, match="unknown kind of surrogate: spectral"):
        open_surrogate(Setting(tmp_path / "weights.pt", "run.h5", CONTACTS, None, torch.device("cpu"), 1.0))


def test_weights_without_a_kind_are_those_of_a_graph_network(tmp_path, monkeypatch):
    opened = []
    monkeypatch.setitem(KINDS, "graph", type("Kind", (), {"open": staticmethod(opened.append)}))
    write_tensors(tmp_path / "weights.pt", {"recipe": {}, "state": {}})
    setting = Setting(tmp_path / "weights.pt", "run.h5", CONTACTS, None, torch.device("cpu"), 1.0)
    open_surrogate(setting)
    assert opened == [setting]
