"""``python -m trackctl``."""

from trackctl.cli.app import main

main()
