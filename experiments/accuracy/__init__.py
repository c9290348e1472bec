"""Errors against exact rays, 50 digits, and what is predicted of them."""
