// Table 1 of Sloan 2017 as a path of windows.
#pragma once

#include <alpenglow/sh/constants.h>

namespace alpenglow::sh::detail {

// Columns w = inf, 16.7, 11.3, 10, 9, 7, 5.6, and zero; rows l = 1, 2, 3. The printed bands are sinc (not sinc^4, as
// the text's eq. 6 has it) with an extra attenuation of the linear band from w = 10 on.
inline constexpr int sloan_columns = ALPENGLOW_SH_WINDOW_COLUMNS;
inline constexpr double sloan_table[3][sloan_columns] = {
    {ALPENGLOW_SH_WINDOW_BAND1}, {ALPENGLOW_SH_WINDOW_BAND2}, {ALPENGLOW_SH_WINDOW_BAND3}};

// Bands 1 and 2 from the table's end: the factor at u columns from the end, and its rise to the next.
struct SloanRows {
    float value[2][sloan_columns] = {};
    float slope[2][sloan_columns] = {};
};

constexpr SloanRows make_sloan_rows() {
    SloanRows rows;
    for (int band = 0; band < 2; ++band) {
        for (int u = 0; u < sloan_columns; ++u) {
            const double value = sloan_table[band][sloan_columns - 1 - u];
            rows.value[band][u] = static_cast<float>(value);
            rows.slope[band][u] =
                u + 1 < sloan_columns ? static_cast<float>(sloan_table[band][sloan_columns - 2 - u] - value) : 0.0F;
        }
    }
    return rows;
}

inline constexpr SloanRows sloan_rows = make_sloan_rows();

} // namespace alpenglow::sh::detail
