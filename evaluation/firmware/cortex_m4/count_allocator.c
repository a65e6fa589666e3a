/*
 * Instructions per call of an exported allocator on an emulated Cortex-M4: mean and largest.
 *
 * Counted as in count_instructions.c; one call is timed by itself, so its count is good to 40.
 */
#include <stdint.h>
#include <stdio.h>

#include THRUSTER_HEADER

#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)
#define CALL(name) JOIN(THRUSTER, name)

#define SYST_CSR (*(volatile uint32_t *)0xE000E010U)
#define SYST_RVR (*(volatile uint32_t *)0xE000E014U)
#define SYST_CVR (*(volatile uint32_t *)0xE000E018U)
#define INSTRUCTIONS_PER_TICK (40U)
#define CALLS (2000)

static uint32_t state = 1U;

/* Even between -1 and 1: Numerical Recipes' linear congruential generator. */
static float even(void)
{
    state = (state * 1664525U) + 1013904223U;
    return ((float)(state >> 8U) / 8388608.0f) - 1.0f;
}

int main(void)
{
    const float largest_n = CALL(_thrust_max_f32)(0.0f);
    uint64_t sum_f32 = 0U;
    uint64_t sum_q = 0U;
    uint32_t most_f32 = 0U;
    uint32_t most_q = 0U;

    SYST_RVR = 0xFFFFFFU;
    SYST_CVR = 0U;
    SYST_CSR = 5U;
    for (int n = 0; n < CALLS; ++n) {
        const float size = largest_n * (float)COUNT * ((float)(n % 8) / 4.0f);
        float wrench[6];
        float velocity[3];
        int32_t wrench_q16[6];
        int32_t velocity_q16[3];
        int16_t codes[COUNT];
        uint32_t from;
        uint32_t ticks;

        for (int k = 0; k < 6; ++k) {
            wrench[k] = size * even() * ((k < 3) ? 1.0f : 0.2f);
            wrench_q16[k] = (int32_t)(wrench[k] * 65536.0f);
        }
        for (int k = 0; k < 3; ++k) {
            velocity[k] = 2.0f * even();
            velocity_q16[k] = (int32_t)(velocity[k] * 65536.0f);
        }
        from = SYST_CVR;
        (void)CALL(_allocate_f32)(wrench, velocity, codes);
        ticks = (from - SYST_CVR) & 0xFFFFFFU;
        sum_f32 += ticks;
        most_f32 = (ticks > most_f32) ? ticks : most_f32;
        from = SYST_CVR;
        (void)CALL(_allocate_q)(wrench_q16, velocity_q16, codes);
        ticks = (from - SYST_CVR) & 0xFFFFFFU;
        sum_q += ticks;
        most_q = (ticks > most_q) ? ticks : most_q;
    }
    (void)printf("allocate_f32 %lu\n", (unsigned long)(sum_f32 * INSTRUCTIONS_PER_TICK / CALLS));
    (void)printf("allocate_f32 at most %lu\n", (unsigned long)(most_f32 * INSTRUCTIONS_PER_TICK));
    (void)printf("allocate_q %lu\n", (unsigned long)(sum_q * INSTRUCTIONS_PER_TICK / CALLS));
    (void)printf("allocate_q at most %lu\n", (unsigned long)(most_q * INSTRUCTIONS_PER_TICK));
    return 0;
}
