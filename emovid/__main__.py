"""`python -m emovid`."""

from emovid.cli.main import run

if __name__ == "__main__":  # a worker process imports this module too
    run()
