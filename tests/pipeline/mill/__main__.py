"""The runner's command line on the toy mill: `python -m mill run RECIPE`."""

import sys

from pipeline.catalog import load_catalog
from pipeline.cli import main

if __name__ == "__main__":
    sys.exit(main(catalog=load_catalog("mill", ("yarn", "weave", "bolt"))))
