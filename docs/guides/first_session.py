# SPDX-License-Identifier: Apache-2.0
# %% [markdown]
# # A first session in Python
#
# Ten things that a researcher does with a recording: read, filter, track, look, score, compare, simulate the hardware, check a
# waveform, tune, export. [The tutorial](../tutorial.md) does the same on the command line. A notebook shows recording, tracks
# and run as pages and pictures ([api.md](../api.md#in-a-notebook)); elsewhere each is a line of text.

# %%
import subprocess
import sys
from pathlib import Path

import numpy as np

import evcot
import evcot_cosim
from evcot_cosim.waves import Wave, after, always

# %% [markdown]
# ## 1. A recording and its numbers
#
# A simulated scene needs no file: four discs cross for a second in front of a noisy sensor. For a file of your own, use
# `recording = evcot.read("drive.raw")`; [recordings.md](../recordings.md) lists the formats.


# %%
def made(seed: int) -> evcot.Scene:
    return evcot.simulate("discs", seed, duration_us=1_000_000, count=4, noise_hz=1.0, hot_pixels=3)


scene = made(seed=4)
recording = scene.recording
evcot.write(recording, "discs.aedat4")
with evcot.open_recording("discs.aedat4") as file:
    found = evcot.describe(file)
print(f"{found.format}, {found.width}x{found.height} pixels, {found.events:,} events in {found.duration_us / 1e6:.3f} s")
print(f"mean rate {found.mean_rate / 1e3:,.0f} k events/s, {found.on_share:.0%} of the events are ON")
recording

# %% [markdown]
# ## 2. Filter noise and hot pixels
#
# Hot pixels are masked. Every other event needs an event of a neighbour in the 5 ms before it; [filters.md](../filters.md) has
# more filters.


# %%
def filtered(recording: evcot.Recording) -> evcot.Recording:
    hot_pixels = evcot.learn_hot_pixels(recording.events, (recording.width, recording.height))
    print("hot pixels:", *hot_pixels)
    return evcot.filter(recording, hot_pixels=hot_pixels, activity_us=5_000)


clean = filtered(recording)
evcot.write(clean, "clean.aedat4")
print(f"{len(clean.events):,} of {len(recording.events):,} events pass")

# %% [markdown]
# ## 3. Track
#
# The default tracker needs no settings. It is the golden model of the hardware `cot_motion` ([motion.md](../motion.md)).

# %%
log = evcot.track(clean)
log

# %% [markdown]
# ## 4. Look at the tracks
#
# `log.tracks` are the tracks as objects. `log.records` is a NumPy array with one row for each birth, move, merge and loss
# ([tracks.md](../tracks.md)); `log.to_pandas()` and `log.tracks.to_pandas()` return data frames. Two discs overlap at the
# start: track 0 covers both until they part. `clean.show(log)` plays the events with the boxes.

# %%
end_us = int(clean.events.t_us[-1])
print("track  born at  lifetime  median speed  centre at 0.5 s")
for track in log.tracks:
    lifetime_us = (track.ended_us or end_us) - track.born_us
    speed = np.median(np.hypot(track.path["vx"], track.path["vy"]))
    box = track.box_at(500_000)
    centre = f"({box.x:.0f}, {box.y:.0f})" if box else "none"
    print(f"{track.id:5}  {track.born_us / 1e3:4.0f} ms {lifetime_us / 1e3:6.0f} ms  {speed:7.0f} px/s  {centre}")
figure = log.plot(clean, ("tracks", "xy"))
figure.savefig("guide_session.png")
figure

# %%
clean.show(log)

# %% [markdown]
# ## 5. Score against the truth
#
# The truth of a simulated scene is exact. HOTA weighs finding the objects against keeping them apart;
# [evaluation.md](../evaluation.md) explains each figure.


# %%
def show(name: str, log: evcot.TrackLog) -> None:
    scores = evcot.evaluate(log, scene.truth)
    error_px = scores.position_error_px_median
    print(f"{name:8} HOTA {scores.hota:.3f}  IDF1 {scores.idf1:.3f}  {scores.idsw} switches  {error_px:.2f} px median error")


show("default", log)

# %% [markdown]
# ## 6. Compare with other engines
#
# `evcot.ENGINES` lists all trackers; a preset, here `discs`, has settings for a kind of scene.
# [Your own tracker](../plug_in.md) can be one of them.

# %%
show("default", log)
show("rct", evcot.track(clean, "rct", "discs"))
show("frames", evcot.track(clean, "frames", "discs"))

# %% [markdown]
# ## 7. Run the hardware
#
# `cosim` simulates the Verilog in lock-step with its golden model and raises `MismatchError` at the first difference. `save`
# writes a report for the browser, the logs, a waveform and `run.toml`. The first call compiles the Verilog in a minute.

# %%
run = evcot_cosim.cosim(clean)
run.save("session")
assert (run.hardware.records == run.model.records).all()
print(f"equal: {len(run.hardware.records):,} records and the owners of {len(run.hardware.owner):,} events")
print(f"{run.cycles / len(clean.events):.2f} clocks per event")
show("hardware", run.hardware)
run.show()

# %% [markdown]
# ## 8. Check a moment in a waveform
#
# Simulate the events around the third birth again, clock for clock, and check two properties of that waveform.
# [waveforms.md](../waveforms.md) has all properties, and views for GTKWave.

# %%
birth = run.hardware.of_kind(evcot.Kind.BORN)[2]
moment = int(birth["event_index"])
evcot_cosim.dump_window(clean.events, run.config.device_config(), Path("birth.vcd"), moment - 100, moment + 300)
s = Wave.open("birth.vcd").sampled("TOP.clk")
sent = s["TOP.m_cm_valid"] & s["TOP.m_cm_ready"]
born = sent & (s["TOP.m_cm_kind"] == evcot.Kind.BORN)
print("births, each with a box:", always((s["TOP.m_cm_width"] > 0) & (s["TOP.m_cm_height"] > 0), where=born))
moved = sent & (s["TOP.m_cm_kind"] == evcot.Kind.MOVED)
print("births, each followed by a move within 400 clocks:", after(born).within(400).expect(moved))

# %% [markdown]
# ## 9. Tune a setting
#
# A keyword changes a register of the default tracker. `side_share` says which share of the events may lie outside a side of the
# box: 2^-n ([motion.md](../motion.md)). The value is tuned on one scene and then tested on a scene with another seed. For large
# sweeps on all cores there is [`evcot sweep`](../sweeps.md).

# %%
test = made(seed=5)
test_clean = filtered(test.recording)
tuned_on = {n: evcot.evaluate(evcot.track(clean, side_share=n), scene.truth).hota for n in (2, 3, 4, 5)}
tested_on = {n: evcot.evaluate(evcot.track(test_clean, side_share=n), test.truth).hota for n in tuned_on}
print("side_share   tuned on    test set")
for n in tuned_on:
    print(f"{n:10}   HOTA {tuned_on[n]:.3f}  HOTA {tested_on[n]:.3f}")
best = max(tuned_on, key=tuned_on.__getitem__)
print(f"chosen: {best}")

# %% [markdown]
# ## 10. Export
#
# Settings in TOML serve Python and the command line: `evcot track clean.aedat4 --config tuned.toml` gives the same log.

# %%
Path("tuned.toml").write_text(f"[motion]\nside_share = {best}\n")
tuned = evcot.track(clean, config="tuned.toml")
command = "track clean.aedat4 --config tuned.toml --output command.npz --quiet"
subprocess.run([sys.executable, "-m", "evcot_cosim", *command.split()], check=True)
assert (evcot.TrackLog.load("command.npz").records == tuned.records).all()

# %% [markdown]
# Tracks are saved as NumPy, Parquet or CSV. Boxes in frames of 20 ms are saved for MOTChallenge and COCO tools, and a film is
# saved as GIF or MP4 ([pictures.md](../pictures.md)).

# %%
tuned.save("tuned.npz")
tuned.save("tuned.csv")
clock = evcot.FrameClock(frame_us=20_000)
boxes = evcot.boxes_of_log(tuned, clock, (clean.width, clean.height))
evcot.write_boxes("tuned.txt", boxes, clock)  # MOTChallenge
evcot.write_boxes("tuned.json", boxes, clock)  # COCO
evcot.render(clean, {"tuned": tuned}, "tuned.gif", speed=0.25, fps=10)
print(Path("tuned.txt").read_text().splitlines()[0])
