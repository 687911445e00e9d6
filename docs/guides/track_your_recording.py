# SPDX-License-Identifier: Apache-2.0
# %% [markdown]
# # Track your recording
#
# Read, look, filter, track with two trackers, draw, score, export: all in Python. The same from the command line is in [the
# tutorial](../tutorial.md).

# %%
from pathlib import Path

import evcot

# %% [markdown]
# ## A recording
#
# A simulated scene stands in, so that this runs anywhere: four discs that cross each other, two seconds, a noisy sensor with
# three hot pixels. With a file of your own, leave the scene out and set `path`: AEDAT, Prophesee RAW and DAT, HDF5, ROS bags,
# CSV and more are recognised by their content ([recordings.md](../recordings.md)).

# %%
path = Path("discs.aedat4")  # <- your file
scene = evcot.simulate("discs", seed=4, duration_us=2_000_000, count=4, noise_hz=1.0, hot_pixels=3)
evcot.write(scene.recording, path)
scene.truth.save("discs.truth.csv")

# %% [markdown]
# ## Look at it

# %%
with evcot.open_recording(path) as file:
    found = evcot.describe(file)
print(f"{found.format}, {found.width}x{found.height} pixels")
print(f"{found.events:,} events in {found.duration_us / 1e6:.3f} s, {found.on_share:.0%} of them ON")
print(f"mean rate {found.mean_rate / 1e3:,.0f} k events/s, peak {found.peak_rate / 1e3:,.0f} k events/s")

recording = evcot.read(path)
sensor = recording.width, recording.height
hot_pixels = evcot.learn_hot_pixels(recording.events, sensor)
print("hot pixels:", *hot_pixels)

# %% [markdown]
# ## Filter
#
# Hot pixels are masked, and an event needs a neighbour within 5 ms. `evcot.filter` shows what that leaves; the trackers below
# take the same filters in front of them, so that their logs number all events of the file.

# %%
filters = evcot.FilterConfig(hot_pixels=hot_pixels, activity_us=5_000)
clean = evcot.filter(recording, filters)
share = len(clean.events) / len(recording.events)
print(f"{len(clean.events):,} of {len(recording.events):,} events stay ({share:.1%})")

# %% [markdown]
# ## Track
#
# Every tracker has presets; `discs` suits round objects of one size that cross. `list(evcot.ENGINES["rct"].presets)` has the
# names. Without engine and preset, `evcot.track(recording)` needs no settings.

# %%
logs = {}
for name in ("rct", "frames"):
    logs[name] = evcot.track(recording, name, "discs", filters=filters)
    owned = (logs[name].owner >= 0).mean()
    print(f"{name:7} {len(set(logs[name].records['track_id']))} tracks, which own {owned:.1%} of all events")

# %% [markdown]
# ## Draw

# %%
evcot.plot(clean, logs, "guide_track.png", ("tracks", "xy"), width_mm=150, dpi=150)

# %% [markdown]
# ## Score
#
# The truth of a scene is known exactly. Without a truth, stop at the picture. HOTA weighs finding the objects against keeping
# them apart; [evaluation.md](../evaluation.md) explains each figure.

# %%
for name, log in logs.items():
    scores = evcot.evaluate(log, "discs.truth.csv", sensor=sensor)
    error_px = scores.position_error_px_median
    print(f"{name:7} HOTA {scores.hota:.3f}  IDF1 {scores.idf1:.3f}  {scores.idsw} switches  {error_px:.2f} px median error")

# %% [markdown]
# ## Export
#
# One line per birth, move, merge and loss. `save_npz` keeps the owner of every event, too, and `TrackLog.load_npz` reads it.

# %%
logs["rct"].write_csv("discs.tracks.csv")
with open("discs.tracks.csv") as file:
    for _ in range(3):
        print(file.readline(), end="")
