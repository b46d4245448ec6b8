"""The front door: the command line, one short function a verb, heavy imports inside."""


def main() -> None:
    raise SystemExit("benchtwin: no command yet")
