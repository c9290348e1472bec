"""The paper's figures and numbers, and the README's pictures."""
