// Stress tests run with floating-point traps on: an invalid operation, a division by zero or an overflow ends the test
// with SIGFPE at the instruction that did it.
#pragma once

#include <cfenv>

#include <gtest/gtest.h>

namespace alpenglow::test {

class FpTraps {
public:
    explicit FpTraps(int exceptions = FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW) : enabled_(exceptions) {
        std::feclearexcept(FE_ALL_EXCEPT);
        previous_ = feenableexcept(enabled_);
    }
    ~FpTraps() {
        fedisableexcept(FE_ALL_EXCEPT);
        std::feclearexcept(FE_ALL_EXCEPT);
        feenableexcept(previous_);
    }
    FpTraps(const FpTraps&) = delete;
    FpTraps& operator=(const FpTraps&) = delete;

private:
    int enabled_;
    int previous_;
};

// TEST_F(SomethingStress, ...): the whole test body runs with traps on.
class StressTest : public ::testing::Test {
    FpTraps traps_;
};

} // namespace alpenglow::test
