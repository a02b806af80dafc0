#include "sandbox/app/sky_charts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include <alpenglow/core/timing.hpp>

#include "sandbox/app/sky_chart.hpp"

namespace alpenglow::sandbox {
namespace {

constexpr int day_samples = 289;       // five minutes apart
constexpr float exposure_step = 0.02F; // change of exposure that shows

bool same(const Atmosphere& a, const Atmosphere& b) {
    const auto fields = [](const Atmosphere& x) {
        return std::tuple(x.model, x.turbidity, x.ozone_atm_cm, x.ground_albedo.r, x.ground_albedo.g, x.ground_albedo.b,
                          x.clearness, x.brightness, x.cie_type, x.zenith_cd_m2);
    };
    return fields(a) == fields(b);
}

bool same(const Observer& a, const Observer& b) {
    return a.latitude_rad == b.latitude_rad && a.longitude_rad == b.longitude_rad && a.height_m == b.height_m;
}

} // namespace

SkyCharts::SkyCharts(BasicRegistry& registry, const ChartSettings& wanted)
    : settings(wanted), registry_(registry), receiver_(registry.create()) {
    registry_.emplace<SkyLightReceiver>(receiver_, SkyLightReceiver{.bands = settings.bands, .visible = false});
}

SkyCharts::~SkyCharts() {
    registry_.destroy(receiver_);
}

void SkyCharts::begin(Stage& /*stage*/) {
    SkyLightReceiver& receiver = registry_.get<SkyLightReceiver>(receiver_);
    receiver.visible = settings.show == Chart::sky;
    receiver.bands = settings.bands;
}

void SkyCharts::update(Stage& stage) {
    if (settings.show == Chart::none || stage.width < 340 || stage.height < 200) {
        stage.drawn.overlay = nullptr;
        sky_key_.reset();
        day_picture_key_.reset();
        day_.clear();
        return;
    }
    SystemReport report{.system = "chart", .considered = 1};
    const double start = thread_cpu_seconds();
    const bool painted = settings.show == Chart::sky ? paint_sky(stage) : paint_day(stage);
    if (painted) {
        overlay_.rgba = canvas_.rgba();
        overlay_.width = canvas_.width();
        overlay_.height = canvas_.height();
        overlay_.left = (stage.width - canvas_.width()) / 2;
        overlay_.top = stage.height - canvas_.height();
        overlay_.revision = next_revision();
    }
    stage.drawn.overlay = &overlay_;
    report.updated = painted ? 1 : 0;
    report.skipped = painted ? 0 : 1;
    report.cpu_ms = (thread_cpu_seconds() - start) * 1e3;
    stage.reports.push_back(report);
}

// False where the picture stands as it is.
bool SkyCharts::paint_sky(const Stage& stage) {
    const SkyState& sky = registry_.get<SkyState>(stage.sky);
    const SkyLightSh& light = registry_.get<SkyLightSh>(stage.sky);
    // Exposure in steps, so that a picture that adapts is not painted in every frame.
    const float exposure = std::exp(std::round(std::log(stage.drawn.exposure) / exposure_step) * exposure_step);
    const SkyKey key{stage.drawn.sky_revision, light.revision, settings.bands, settings.filter, exposure, stage.width};
    if (sky_key_ == key) {
        return false;
    }
    sky_key_ = key;
    day_picture_key_.reset();
    canvas_ = paint_sky_chart(sky, registry_.try_get<SkyTables>(stage.sky), light, settings.bands, settings.filter,
                              exposure, stage.width);
    return true;
}

bool SkyCharts::paint_day(const Stage& stage) {
    const Observer& observer = registry_.get<Observer>(stage.sky);
    const Atmosphere& air = registry_.get<SkyState>(stage.sky).air; // as the sky was made, within its range
    const double now = registry_.get<WorldClock>(stage.sky).utc_j2000_s;
    const bool today = !day_.empty() && now >= day_.front().utc_j2000_s && now <= day_.back().utc_j2000_s;
    const bool fresh = today && same(observer, day_observer_) && same(air, day_air_);
    if (!fresh) {
#ifdef ALPENGLOW_WITH_EPHEMERIS
        day_ = day_light(observer, air, now, day_samples);
#endif
        day_observer_ = observer;
        day_air_ = air;
    }
    const int width = std::min(stage.width, 760);
    const int height = std::min(stage.height / 2, 300);
    const auto minute = static_cast<long>(std::floor(now / 60.0));
    const DayPictureKey key{width, height, minute};
    if (fresh && day_picture_key_ == key) {
        return false;
    }
    day_picture_key_ = key;
    sky_key_.reset();
    canvas_ = paint_day_chart(day_, now, width, height);
    return true;
}

void SkyCharts::draw_panel(PanelWriter& panel) {
    static constexpr std::array<const char*, 3> charts{"none", "sky and its SH", "light of the day"};
    auto show = static_cast<int>(settings.show);
    if (panel.choice("chart", charts, show)) {
        settings.show = static_cast<Chart>(show);
    }
    if (settings.show != Chart::sky) {
        return;
    }
    static constexpr std::array<const char*, 7> numbers{"1", "2", "3", "4", "5", "6", "7"};
    int bands = settings.bands - 1;
    if (panel.choice("bands", numbers, bands)) {
        settings.bands = bands + 1;
    }
    static constexpr std::array<const char*, 2> filters{"least blur", "sinc"};
    auto filter = static_cast<int>(settings.filter);
    if (panel.choice("filter", filters, filter)) {
        settings.filter = static_cast<ChartFilter>(filter);
    }
}

bool SkyCharts::press(int key) {
    if (key != 'V') {
        return false;
    }
    settings.show = static_cast<Chart>((static_cast<int>(settings.show) + 1) % 3);
    return true;
}

} // namespace alpenglow::sandbox
