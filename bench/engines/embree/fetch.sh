#!/usr/bin/env bash
# Gets Embree 4 as the shared library inside a wheel of the Python package `embreex` and prints its path:
#   export ANTUMBRA_EMBREE_LIB=$(bench/engines/embree/fetch.sh)
# Nothing is installed; the wheel is unpacked below bench/target.
set -euo pipefail
VERSION=4.4.0.post1
TO=$(cd "$(dirname "$0")/../.." && pwd)/target/embree-$VERSION
find_library() { find "$TO" -name 'libembree4*.so*' -type f 2>/dev/null | head -1; }
if [ -z "$(find_library)" ]; then
  mkdir -p "$TO"
  python3 -m pip download --quiet --no-deps --only-binary=:all: --dest "$TO" "embreex==$VERSION" >&2
  python3 -m zipfile -e "$TO"/embreex-*.whl "$TO"
fi
LIBRARY=$(find_library)
[ -n "$LIBRARY" ] || { echo "no Embree library in the wheel" >&2; exit 1; }
echo "$LIBRARY"
