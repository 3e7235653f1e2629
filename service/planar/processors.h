/// One function for several processors.
#pragma once

/// A function marked so is compiled twice, with all that it calls whose code is at hand: for any x86-64, and for those
/// that have AVX2 and FMA (since 2013). Which of the two is called the loader decides, by the processor it finds.
/// Elsewhere, and by Clang, it is compiled once.
#if defined(__x86_64__) && defined(__GLIBC__) && !defined(__clang__)
#define TORQUED_FOR_PROCESSORS __attribute__((target_clones("default", "arch=x86-64-v3"), flatten))
#else
#define TORQUED_FOR_PROCESSORS
#endif
