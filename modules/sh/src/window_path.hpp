// Table 1 of Sloan 2017 as a path of windows.
#pragma once

namespace alpenglow::sh::detail {

// Columns w = inf, 16.7, 11.3, 10, 9, 7, 5.6, and zero; rows l = 1, 2, 3. The printed bands are sinc (not sinc^4, as
// the text's eq. 6 has it) with an extra attenuation of the linear band from w = 10 on.
inline constexpr int sloan_columns = 8;
inline constexpr double sloan_table[3][sloan_columns] = {
    {1.0, 0.9941, 0.9872, 0.9634, 0.9602, 0.9184, 0.8915, 0.0},
    {1.0, 0.9766, 0.9493, 0.9355, 0.9207, 0.8710, 0.8030, 0.0},
    {1.0, 0.9478, 0.8880, 0.8584, 0.8270, 0.7241, 0.5904, 0.0},
};

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
