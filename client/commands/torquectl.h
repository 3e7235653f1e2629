/// The command line of torquectl.
#pragma once

namespace torqued
{

/// Runs torquectl with the arguments of main(); returns its exit code (failure.h). Complains in one line on stderr.
int torquectl(int argc, const char* const* argv);

} // namespace torqued
