// The sandbox from options to exit code.
#pragma once

#include "sandbox/cli/options.hpp"

namespace alpenglow::sandbox {

// Exit codes that others script against.
enum class Exit { fine = 0, failed = 1, bad_input = 2, no_device = 3 };

[[nodiscard]] Exit run(const Options& options);

} // namespace alpenglow::sandbox
