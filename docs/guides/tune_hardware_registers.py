# SPDX-License-Identifier: Apache-2.0
# %% [markdown]
# # Tune hardware registers
#
# The golden model computes exactly what the RTL computes, in software and without a compiled simulation. So registers are
# tuned on the model, proven once on the RTL, and then written into the chip.

# %%
from dataclasses import replace

from matplotlib.figure import Figure

import evcot
import evcot_cosim
from evcot import REGISTERS, CotConfig, RunConfig, Scene, Scores, SlotConfig

# %% [markdown]
# ## Two recordings with a truth
#
# Four discs for a second: one recording to tune on, another to see whether the choice holds on what it has not seen.
# Recordings of your own need boxes in a CSV file ([evaluation.md](../evaluation.md)).


# %%
def made(seed: int) -> Scene:
    return evcot.simulate("discs", seed, duration_us=1_000_000, count=4, truth_step_us=5_000)


tune, check = made(1), made(3)

# %% [markdown]
# ## The registers that matter
#
# The preset for the sensor is the start. These four decide most; [registers.md](../registers.md) has all fifteen.

# %%
start = evcot.run_config(346, 260, hardware="cot_array")
for name in ("clust_nev", "init_radix", "hist_avg", "max_ticks"):
    print(f"{name:10} {getattr(start.hardware.slots[0], name):6}  {REGISTERS[name].meaning}")

# %% [markdown]
# ## Sweep two of them
#
# N_ev, how many events make a centre, and g, the inner radius of the window; each with its limits around it.


# %%
def with_registers(n_ev: int, g: int) -> SlotConfig:
    limits = {"nev_min": n_ev, "nev_max": n_ev, "radix_min": g - 2, "radix_max": g + 2}
    return replace(start.hardware.slots[0], clust_nev=n_ev, init_radix=g, **limits)


def configured(slot: SlotConfig) -> RunConfig:
    hardware = start.hardware
    return replace(start, name="tuned", hardware=CotConfig.uniform(hardware.shape, slot, hardware.tick_us))


def score(slot: SlotConfig, scene: Scene) -> Scores:
    return evcot.evaluate(evcot.track(scene.recording, "cot_array", settings=configured(slot)), scene.truth)


n_evs, radii = (2, 4, 8, 16, 32), (4, 6, 8, 10, 12)
scores = {(n_ev, g): score(with_registers(n_ev, g), tune) for n_ev in n_evs for g in radii}
print("HOTA  " + "".join(f"  g = {g:<3}" for g in radii))
for n_ev in n_evs:
    print(f"N_ev {n_ev:<3}" + "".join(f"{scores[n_ev, g].hota:7.3f} " for g in radii))

# %%
figure = Figure(figsize=(5, 2.8), layout="constrained")
axes = figure.subplots()
for g in radii:
    axes.plot(n_evs, [scores[n_ev, g].hota for n_ev in n_evs], marker="o", label=f"g = {g}")
axes.set(xscale="log", xlabel="N_ev", ylabel="HOTA", xticks=n_evs, xticklabels=[str(n_ev) for n_ev in n_evs])
axes.minorticks_off()
axes.legend(frameon=False, loc="center left", bbox_to_anchor=(1, 0.5))
figure.savefig("guide_sweep.png", dpi=150)

# %% [markdown]
# ## Choose, and see whether it holds

# %%
n_ev, g = max(scores, key=lambda key: scores[key].hota)
chosen = with_registers(n_ev, g)
print(f"chosen: N_ev = {n_ev}, g = {g}")
for name, scene in (("tuned on", tune), ("not seen", check)):
    before, now = score(start.hardware.slots[0], scene), score(chosen, scene)
    print(f"{name}: HOTA {before.hota:.3f} -> {now.hota:.3f}, switches {before.idsw} -> {now.idsw}")

# %% [markdown]
# ## Prove it on the RTL
#
# `cosim` runs the Verilog in lock-step with the model and raises `MismatchError` at the first bit that differs, stalls on
# every stream included. `save` writes report, logs and run.toml; `evcot cosim --config tuned/run.toml` repeats the run.

# %%
config = configured(chosen)
run = evcot_cosim.cosim(check.recording, config, stall_seed=7)
assert (run.hardware.records == run.model.records).all()
assert (run.hardware.owner == run.model.owner).all()
print(f"exact: {len(run.hardware.records):,} records, the owners of {len(run.hardware.owner):,} events")
run.save("tuned")

# %% [markdown]
# ## Write them into the chip
#
# `Registers` writes by name over anything that reads and writes words: a mapped memory, a serial line, a simulation. Here a
# stand-in for the bus prints each write, beside the same in C with `hw/include/evcot_regs.h`. A commit lets them take effect
# together, between two events.


# %%
class PrintedBus:
    """Says of itself what an evcot_top of this shape says, and prints what is written."""

    def __init__(self) -> None:
        at, shape = evcot.register_map(), config.hardware.shape
        says = {"id": at.id, "version_major": at.version[0], "version_minor": at.version[1], "memory_stamp_w": 20}
        self.words = {
            word.address: sum(says.get(word.port(f), getattr(shape, f.name, 0)) << f.lsb for f in word.fields)
            for word in at.words
        }
        self.names = {at.banks["slot"].base + 4 * register.address: name for name, register in REGISTERS.items()}

    def read(self, address: int) -> int:
        return self.words[address]

    def write(self, address: int, value: int) -> None:
        name = self.names.get(address, "commit")
        print(f"0x{address:04x} = {value:<5} REG(regs, EVCOT_SLOT(0, EVCOT_SLOT_{name.upper()})) = {value};")


slot = evcot.Registers(PrintedBus()).slot[0]
for name in REGISTERS:
    if getattr(chosen, name) != getattr(start.hardware.slots[0], name):
        setattr(slot, name, getattr(chosen, name))  # slot.clust_nev = 4, and so on
slot.commit()
