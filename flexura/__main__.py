"""The program: ``flexura`` and ``python -m flexura``, with our packages whatever lies where it is called."""

from flexura.own_packages import put_first


def main() -> None:
    """Run one verb, and exit as `app.main.main` says."""
    put_first()
    from app.main import main as run

    run()


if __name__ == "__main__":
    main()
