#include <alpenglow/core/result.hpp>

#include <gtest/gtest.h>

namespace alpenglow {
namespace {

Result<int> half(int n) {
    if (n % 2 != 0) {
        return Error{"3 is odd", "n", "an even number"};
    }
    return n / 2;
}

TEST(Result, CarriesAValueOrAnError) {
    ASSERT_TRUE(half(4));
    EXPECT_EQ(*half(4), 2);
    ASSERT_FALSE(half(3));
    EXPECT_EQ(half(3).error().message(), "n: 3 is odd (expected an even number)");
}

TEST(Error, LeavesEmptyPartsOut) {
    EXPECT_EQ((Error{"no device", "", ""}.message()), "no device");
}

} // namespace
} // namespace alpenglow
