// Limits dynamic dispatch on x86-64 to two instruction sets: the baseline and AVX2 with FMA. Later sets bring nothing
// for lanes of four. Include it before <hwy/foreach_target.h>, and all other headers before it, so that their functions
// are inlined or compiled for the baseline.
#pragma once

#undef HWY_DISABLED_TARGETS
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | (HWY_AVX2 - 1))
