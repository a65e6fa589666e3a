/*
 * Instructions per call on an emulated Cortex-M4, for one thruster library.
 *
 * QEMU with -icount shift=0 lets one nanosecond of virtual time pass for each instruction. The
 * system timer runs at 25 MHz, so one tick is 40 instructions, and many calls make that fine.
 * The loop around an empty function is taken off. THRUSTER names the functions' prefix. The first
 * line counts 4000 instructions that do nothing, to show that the clock counts what it should.
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
#define INSTRUCTIONS_PER_TICK (40.0)

#define STEPS (64)
#define SPEEDS (16)

static volatile float sink_f32;
static volatile int32_t sink_q;

static float thrust_f32[STEPS];
static float speed_f32[SPEEDS];
static int32_t thrust_q16[STEPS];
static int32_t speed_q16[SPEEDS];
static int16_t code[STEPS];

/* Not inlined, so that the empty loop pays for a call as the others do. */
__attribute__((noinline)) static int16_t nothing_f32(float thrust_n, float speed_mps)
{
    __asm volatile("" : : "t"(thrust_n), "t"(speed_mps));
    return 0;
}

__attribute__((noinline)) static int16_t nothing_q(int32_t thrust_n, int32_t speed_mps)
{
    __asm volatile("" : : "r"(thrust_n), "r"(speed_mps));
    return 0;
}

static uint32_t start(void)
{
    return SYST_CVR;
}

/* Ticks since start(); the timer counts down over 24 bits. */
static double elapsed(uint32_t from)
{
    return (double)((from - SYST_CVR) & 0xFFFFFFU) * INSTRUCTIONS_PER_TICK;
}

/* A function of its own: so long a block would push constants out of reach of others. */
__attribute__((noinline)) static void nops_4000(void)
{
    __asm volatile(".rept 4000\n nop\n .endr");
}

static double elapsed_over_4000_nops(void)
{
    const uint32_t from = start();

    nops_4000();
    return elapsed(from);
}

#define MEASURE(result, sink, expression)                                                          \
    do {                                                                                           \
        const uint32_t from = start();                                                             \
        for (int v = 0; v < SPEEDS; ++v) {                                                         \
            for (int i = 0; i < STEPS; ++i) {                                                      \
                (sink) = (expression);                                                             \
            }                                                                                      \
        }                                                                                          \
        (result) = elapsed(from) / (double)(SPEEDS * STEPS);                                       \
    } while (0)

int main(void)
{
    double empty_f32 = 0.0;
    double empty_q = 0.0;
    double calls = 0.0;

    const float largest_n = CALL(_thrust_max_f32)(0.0f);

    for (int i = 0; i < STEPS; ++i) {
        const float share = ((float)i + 0.5f) / (float)STEPS;

        /* Live thrusts and codes only: inside the dead zone a call returns at once. */
        thrust_f32[i] = (0.05f + (0.95f * share)) * largest_n;
        thrust_q16[i] = (int32_t)(thrust_f32[i] * 65536.0f);
        code[i] = CALL(_code_from_thrust_f32)(thrust_f32[i], 0.0f);
    }
    for (int v = 0; v < SPEEDS; ++v) {
        speed_f32[v] = 2.0f * ((float)v + 0.5f) / (float)SPEEDS;
        speed_q16[v] = (int32_t)(speed_f32[v] * 65536.0f);
    }
    SYST_RVR = 0xFFFFFFU;
    SYST_CVR = 0U;
    SYST_CSR = 5U; /* processor clock, no interrupt, on */

    calls = elapsed_over_4000_nops();
    (void)printf("calibration_4000 %.0f\n", calls);
    MEASURE(empty_f32, sink_q, nothing_f32(thrust_f32[i], speed_f32[v]));
    MEASURE(empty_q, sink_q, nothing_q(thrust_q16[i], speed_q16[v]));
    MEASURE(calls, sink_q, CALL(_code_from_thrust_f32)(thrust_f32[i], speed_f32[v]));
    (void)printf("code_from_thrust_f32 %.0f\n", calls - empty_f32);
    MEASURE(calls, sink_q, CALL(_code_from_thrust_q)(thrust_q16[i], speed_q16[v]));
    (void)printf("code_from_thrust_q %.0f\n", calls - empty_q);
    MEASURE(calls, sink_f32, CALL(_thrust_from_code_f32)(code[i], speed_f32[v]));
    (void)printf("thrust_from_code_f32 %.0f\n", calls - empty_f32);
    MEASURE(calls, sink_q, CALL(_thrust_from_code_q)(code[i], speed_q16[v]));
    (void)printf("thrust_from_code_q %.0f\n", calls - empty_q);
    MEASURE(calls, sink_f32, CALL(_thrust_max_f32)(speed_f32[v]));
    (void)printf("thrust_max_f32 %.0f\n", calls - empty_f32);
    MEASURE(calls, sink_q, CALL(_thrust_max_q)(speed_q16[v]));
    (void)printf("thrust_max_q %.0f\n", calls - empty_q);
    return 0;
}
