// Of the instruction sets of x86-64, what is dispatched is compiled for two: its own and AVX2 with FMA. What comes
// after that has nothing for lanes of four. To be included before <hwy/foreach_target.h>; all other headers come before
// it, so that their functions are inlined, or of the first.
#pragma once

#undef HWY_DISABLED_TARGETS
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | (HWY_AVX2 - 1))
