"""One script per claim; `README.md` lists them."""
