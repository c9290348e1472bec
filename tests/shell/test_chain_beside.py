"""`fit --mcmc --force` in a folder with the draws of another fit."""

from types import SimpleNamespace

import fitting
from fitting.sampling import OtherChainError
from fitting.shell import fit_verb
from fitting.shell.answer import Outputs


def test_the_draws_of_another_fit_are_put_beside(tmp_path, monkeypatch, capsys):
    chain, draws = tmp_path / "chain.h5", []

    def sample(result, path, progress, **settings):
        assert settings == {"steps": 99}
        if path.exists():
            raise OtherChainError("the draws are of another fit")
        draws.append(path)
        return SimpleNamespace()

    monkeypatch.setattr(fitting, "sample", sample)
    for number, content in enumerate((b"first", b"second"), 1):
        chain.write_bytes(content)
        fit_verb._chain(SimpleNamespace(), Outputs(folder=tmp_path, force=True), {"steps": 99})
        assert (tmp_path / f"chain-{number}.h5").read_bytes() == content
        assert f"the draws of another fit are kept in {tmp_path / f'chain-{number}.h5'}" in capsys.readouterr().err
    assert draws == [chain, chain]
