# SPDX-License-Identifier: Apache-2.0
"""One module per family of event file; `evcot.files.read_recording` is the way in.

Each reader takes the path of a file of its own kind and returns a `Decoded`. What it finds wrong it raises as a
RecordingError that leaves the file's name out: `read_recording` puts it in front.
"""
