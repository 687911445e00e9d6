// SPDX-License-Identifier: Apache-2.0
// A lean hand-written Verilator main for cot_array: the baseline for the streaming drive.
// bare EVENTS: reads events and register writes from a file, then runs a pass for every line on standard input and prints
// "wall_s cpu_s records owner_sum" for it. Only the drive is timed.
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <memory>
#include <vector>

#include "Vcot_array.h"

struct Record {
    uint64_t seq, time;
    uint32_t track_id, other_id, cm_x, cm_y, support;
    uint16_t radius, n_ev;
    uint8_t slot, kind;
};

struct Write {
    uint32_t slot, address, data;
};

template <typename T>
std::vector<T> read_array(std::FILE* file, int64_t length) {
    std::vector<T> values(length);
    if (std::fread(values.data(), sizeof(T), length, file) != static_cast<size_t>(length)) throw 1;
    return values;
}

void clock_up_and_down(Vcot_array* top) {
    top->clk = 1;
    top->eval();
    top->clk = 0;
    top->eval();
}

int main(int argc, char** argv) {
    std::FILE* file = argc == 2 ? std::fopen(argv[1], "rb") : nullptr;
    if (!file) return 2;
    const auto head = read_array<int64_t>(file, 3);
    const int64_t n = head[0], tick_max = head[1];
    const auto writes = read_array<Write>(file, head[2]);
    const auto ticks = read_array<int64_t>(file, n);
    const auto x = read_array<uint16_t>(file, n);
    const auto y = read_array<uint16_t>(file, n);
    const auto p = read_array<uint8_t>(file, n);

    while (std::getchar() != EOF) {
        VerilatedContext context;
        auto model = std::make_unique<Vcot_array>(&context);
        Vcot_array* top = model.get();
        top->rst = 1;
        clock_up_and_down(top);
        clock_up_and_down(top);
        top->rst = 0;
        top->cfg_valid = 1;
        for (const Write& write : writes) {
            top->cfg_slot = write.slot;
            top->cfg_addr = write.address;
            top->cfg_data = write.data;
            clock_up_and_down(top);
        }
        top->cfg_valid = 0;
        while (!top->idle) clock_up_and_down(top);
        top->m_cm_ready = top->m_own_ready = top->m_pass_ready = 1;

        const std::clock_t cpu = std::clock();
        const auto wall = std::chrono::steady_clock::now();
        std::vector<int16_t> owner(n);
        std::vector<uint16_t> rel_x(n), rel_y(n);
        std::vector<Record> records;
        int64_t next = 0, now = 0;
        do {
            top->s_valid = next < n;
            if (top->s_valid) {
                const int64_t wait = ticks[next] - now;
                top->s_event = wait <= tick_max;
                top->s_tick = top->s_event ? wait : tick_max;
                top->s_x = x[next];
                top->s_y = y[next];
                top->s_p = p[next];
            }
            top->clk = 0;
            top->eval();
            if (top->s_valid && top->s_ready) {
                now += top->s_tick;
                next += top->s_event;
            }
            if (top->m_cm_valid)
                records.push_back({top->m_cm_seq, top->m_cm_time, top->m_cm_id, top->m_cm_other, top->m_cm_x, top->m_cm_y,
                                   top->m_cm_support, top->m_cm_radius, top->m_cm_n_ev, top->m_cm_slot, top->m_cm_kind});
            if (top->m_own_valid) {
                const int64_t seq = top->m_own_seq;
                owner[seq] = top->m_own_slot;
                rel_x[seq] = top->m_own_x;
                rel_y[seq] = top->m_own_y;
            }
            if (top->m_pass_valid) {
                const int64_t seq = top->m_pass_seq;
                owner[seq] = -1;
                rel_x[seq] = rel_y[seq] = 0;
            }
            top->clk = 1;
            top->eval();
        } while (next < n || !top->idle);
        const std::chrono::duration<double> wall_s = std::chrono::steady_clock::now() - wall;
        const double cpu_s = static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC;

        int64_t owner_sum = 0;
        for (const int16_t slot : owner) owner_sum += slot;
        std::printf("%.6f %.6f %zu %lld\n", wall_s.count(), cpu_s, records.size(), static_cast<long long>(owner_sum));
        std::fflush(stdout);
    }
}
