# SPDX-License-Identifier: Apache-2.0
"""Print one C++ file that includes all files of a model. make runs this in place of Verilator's own script, with its arguments.

Code that runs only once, which Verilator writes to files of its own, is not optimised: builds are shorter, at the same speed.
EVCOT_ONE_TRIGGER is defined if nothing but the clock triggers a part of the model. Nothing but `sys` is imported, so that it
starts at once.
"""

import sys

_SLOW = "__Slow.cpp"
_TRIGGERED = "ULL & vlSelfRef.__V"  # behind the bit of a trigger
_UNOPTIMISED = """#pragma GCC push_options
#pragma GCC optimize ("O0")
#pragma GCC diagnostic ignored "-Wattributes"
#include "{}"
#pragma GCC pop_options"""


def main(arguments: list[str]) -> None:
    """Print the file for -DNAME=VALUE and names of C++ files, in their order."""
    if has_one_trigger([argument for argument in arguments if not argument.startswith("-D")]):
        print("#define EVCOT_ONE_TRIGGER")
    for argument in arguments:
        if argument.startswith("-D"):
            name, _, value = argument[2:].partition("=")
            print(f"#define {name} {value}")
        elif argument.endswith(_SLOW):
            print(_UNOPTIMISED.format(argument))  # declares fast functions again, which stay as they are
        else:
            print(f'#include "{argument}"')


def has_one_trigger(names: list[str]) -> bool:
    """Whether the code in these files asks for the first trigger alone; False if one cannot be read: the compiler says so."""
    asked = set()
    try:
        for name in names:
            with open(name, encoding="utf-8") as file:
                before = file.read().split(_TRIGGERED)[:-1]
            asked |= {text[text.rfind("(") + 1 :] for text in before}
    except OSError:
        return False
    return asked == {"1"}


if __name__ == "__main__":
    main(sys.argv[1:])
