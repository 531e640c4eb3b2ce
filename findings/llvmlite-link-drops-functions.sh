#!/usr/bin/env bash
# llvmlite 0.50.0 (LLVM 22): modules with functions of linkage linkonce_odr, which numba gives to those it exports, in pairs.
# Guess:     ModuleRef.link_in adds the functions of the other module, in whatever order modules are linked.
# Behaviour: a function that nothing in the receiving module has called so far is left out, without an error. A module that
#            is linked later and calls it has an undefined symbol. With all modules linked into the caller, or with the
#            linkage weak_odr, the function is kept.
# Output seen: linkonce_odr: into the caller True, in pairs False; weak_odr: True, True
# Source:    LLVM language reference, linkage types: globals of linkage linkonce that are not referenced may be discarded;
#            numba/core/codegen.py, CodeLibrary._get_module_for_linking, sets linkonce_odr.
# Here:      kernels are linked in pairs, as weak_odr.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/v" && "$folder/v/bin/pip" install --quiet llvmlite==0.50.0
"$folder/v/bin/python" - <<'PYTHON'
import llvmlite.binding as llvm

CALLER = """declare double @twice(double)
define double @four_times(double %x) {
  %y = call double @twice(double %x)
  %z = call double @twice(double %y)
  ret double %z
}
"""
OTHER = "define double @same(double %x) {\n  ret double %x\n}\n"


def linked(linkage, in_pairs):
    called = f"define {linkage} double @twice(double %x) {{\n  %y = fadd double %x, %x\n  ret double %y\n}}\n"
    caller, other, library = map(llvm.parse_assembly, (CALLER, OTHER, called))
    (other if in_pairs else caller).link_in(library)
    caller.link_in(other)
    return not caller.get_function("twice").is_declaration


found = {linkage: [linked(linkage, in_pairs) for in_pairs in (False, True)] for linkage in ("linkonce_odr", "weak_odr")}
print(f"llvmlite {'.'.join(map(str, llvm.llvm_version_info))}", found)
assert found == {"linkonce_odr": [True, False], "weak_odr": [True, True]}
PYTHON
