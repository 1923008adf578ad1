"""``python -m app`` is ``flexura``."""

from app.main import main

main()
