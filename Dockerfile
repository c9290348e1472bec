# The page of `newtonjax app`. It is reached at http://127.0.0.1:8080/ of this machine alone:
#     docker build --tag newtonjax . && docker run --rm --publish 127.0.0.1:8080:8080 newtonjax
FROM python:3.11-slim-bookworm
WORKDIR /opt/newtonjax
COPY pyproject.toml requirements.lock README.md LICENSE ./
COPY man man
COPY newtonjax newtonjax
COPY fitting fitting
# The lock's versions without its hashes: it does not have what the page needs besides.
RUN sed -E '/^ +--hash/d; s/ *\\$//' requirements.lock > constraints.txt \
    && pip install --no-cache-dir --constraint constraints.txt ".[app]"
# A user that may write nothing but compiled programs.
ENV JAX_COMPILATION_CACHE_DIR=/tmp/compiled HOME=/tmp
USER 1000
EXPOSE 8080
HEALTHCHECK --start-period=60s CMD ["python", "-c", "import urllib.request; urllib.request.urlopen('http://127.0.0.1:8080/')"]
CMD ["newtonjax", "app", "--host", "0.0.0.0"]
