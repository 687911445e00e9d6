# SPDX-License-Identifier: Apache-2.0
"""What the baselines `frames` and `mean-shift` share: detections become tracks, frame by frame."""
