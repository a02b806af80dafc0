// Charts over the picture: the sky beside its spherical harmonics, and the light of the day. Nothing is computed while
// none is shown.
#pragma once

#include <cstdint>
#include <optional>
#include <tuple>
#include <vector>

#include <alpenglow/components/observer.hpp>
#include <alpenglow/components/sky.hpp>

#include "sandbox/app/canvas.hpp"
#include "sandbox/app/day_chart.hpp"
#include "sandbox/app/part.hpp"
#include "sandbox/scene/chart_settings.hpp"
#include "sandbox/world/overlay_render_data.hpp"

namespace alpenglow::sandbox {

class SkyCharts final : public Part {
public:
    SkyCharts(BasicRegistry& registry, const ChartSettings& wanted);
    ~SkyCharts() override;
    SkyCharts(const SkyCharts&) = delete;
    SkyCharts& operator=(const SkyCharts&) = delete;

    void begin(Stage& stage) override;
    void update(Stage& stage) override;
    void draw_panel(PanelWriter& panel) override;
    bool press(int key) override; // V: the next chart

    ChartSettings settings;

private:
    bool paint_sky(const Stage& stage);
    bool paint_day(const Stage& stage);

    BasicRegistry& registry_;
    BasicRegistry::entity_type receiver_; // asks for the sky's bands while its chart is shown
    Canvas canvas_;
    OverlayRenderData overlay_;
    // What the picture was painted from; none of the two: nothing.
    using SkyKey = std::tuple<std::uint32_t, std::uint32_t, int, ChartFilter, float, int>;
    using DayPictureKey = std::tuple<int, int, long>;
    std::optional<SkyKey> sky_key_;
    std::optional<DayPictureKey> day_picture_key_;
    // The day's samples, and what they were made from.
    std::vector<DaySample> day_;
    double day_start_s_ = 0.0;
    Observer day_observer_;
    Atmosphere day_air_;
};

} // namespace alpenglow::sandbox
