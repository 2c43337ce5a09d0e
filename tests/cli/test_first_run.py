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


def test_the_first_run_of_a_kernel_is_announced(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(compiled, "kernel_folder", lambda: tmp_path)
    (tmp_path / "polish.measure-1.py311.1.nbc").touch()
    announce_compilation(quiet=False, kernel="polish.polish")
    assert "compiling kernels, once" in capsys.readouterr().err
    (tmp_path / "polish.polish-2.py311.1.nbc").touch()
    announce_compilation(quiet=False, kernel="polish.polish")
    assert capsys.readouterr() == ("", "")
