from trackctl import compiled
from trackctl.cli.first_run import announce_compilation


def test_only_the_first_run_is_announced(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(compiled, "kernel_folder", lambda: tmp_path)
    announce_compilation(quiet=True)
    assert capsys.readouterr().err == ""
    announce_compilation(quiet=False)
    assert "compiling kernels, once" in capsys.readouterr().err
    (tmp_path / "kernel.nbc").touch()
    announce_compilation(quiet=False)
    assert capsys.readouterr() == ("", "")
