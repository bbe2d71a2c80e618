#!/usr/bin/env bash
# Builds ompl.cpp and runs it beside ours, in the benchmark `routes`. Needs a C++ compiler and Debian's libompl-dev.
# Writes the anytime curve to FILE, by default the one from which `hopper gallery` draws.
# Usage: ompl.sh [FILE]
set -euo pipefail
curve=$(realpath "${1:-$(dirname "$0")/anytime.csv}")
cd "$(dirname "$0")/../../.."
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
g++ -O3 -march=native -std=c++17 -I/usr/include/ompl-1.5 -I/usr/include/eigen3 research/p21/benches/ompl.cpp -lompl -o "$out/ompl"
cargo bench -p p21 --bench routes -- --anytime "$out/ompl" "$curve"
