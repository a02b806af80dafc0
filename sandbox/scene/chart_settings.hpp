// The section `chart` of a scene.
#pragma once

#include <array>
#include <string_view>

namespace alpenglow::sandbox {

class Reader;

enum class Chart { none, sky, day };
enum class ChartFilter { least_blur, sinc };

inline constexpr std::array<std::string_view, 3> chart_names{"none", "sky", "day"};        // as Chart
inline constexpr std::array<std::string_view, 2> chart_filter_names{"least-blur", "sinc"}; // as ChartFilter

// Which chart lies over the picture.
struct ChartSettings {
    Chart show = Chart::none;
    int bands = 5; // of the sky's SH, 1 .. 7
    ChartFilter filter = ChartFilter::least_blur;
};

[[nodiscard]] ChartSettings read_chart_settings(Reader& section);

} // namespace alpenglow::sandbox
