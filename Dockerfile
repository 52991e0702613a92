# cohaptic as a command (FMUs are unpacked into /tmp and loaded from there, hence exec):
#   docker run --rm --read-only --tmpfs /tmp:exec -v "$PWD":/work cohaptic run my.yaml
FROM python:3.12-slim AS build
COPY . /source
# The wheel's build hook compiles the FMUs with ziglang from the registry; no compiler is installed.
RUN pip wheel --no-cache-dir --wheel-dir /wheels /source

FROM python:3.12-slim
RUN --mount=type=bind,from=build,source=/wheels,target=/wheels \
    pip install --no-cache-dir --compile --no-index --find-links /wheels cohaptic \
    && useradd --uid 1000 --create-home --home-dir /home/cohaptic cohaptic \
    && mkdir /work && chown cohaptic /work
USER cohaptic
WORKDIR /work
# Nothing but /work and /tmp has to be writable.
ENV COHAPTIC_CACHE_DIR=/tmp/cohaptic MPLCONFIGDIR=/tmp/matplotlib PYTHONDONTWRITEBYTECODE=1
ENTRYPOINT ["cohaptic"]
CMD ["--help"]
