#include "sandbox/app/panel.hpp"

#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sandbox/scene/calendar.hpp"

namespace alpenglow::sandbox {
namespace {

constexpr double degree = std::numbers::pi / 180.0;

double altitude_deg(const glm::vec3& direction) {
    return static_cast<double>(std::atan2(direction.z, std::hypot(direction.x, direction.y))) / degree;
}

double azimuth_deg(const glm::vec3& direction) {
    const double azimuth = static_cast<double>(std::atan2(direction.x, direction.y)) / degree;
    return azimuth < 0.0 ? azimuth + 360.0 : azimuth;
}

void draw_time(Game& game, double shown_utc_j2000_s) {
    WorldClock& clock = game.clock();
    Date date = date_of(shown_utc_j2000_s);
    int day[3] = {date.year, date.month, date.day};
    if (ImGui::InputInt3("date (UTC)", day, ImGuiInputTextFlags_EnterReturnsTrue)) {
        date.year = day[0];
        date.month = day[1];
        date.day = day[2];
        // A date that does not exist is left unsaid: the field shows the valid one again.
        if (const auto utc = utc_of(date)) {
            clock.utc_j2000_s = *utc;
        }
    }
    const double midnight = shown_utc_j2000_s - date.seconds;
    auto hours = static_cast<float>((shown_utc_j2000_s - midnight) / 3600.0);
    if (ImGui::SliderFloat("hour (UTC)", &hours, 0.0F, 23.999F, "%.2f")) {
        clock.utc_j2000_s = midnight + static_cast<double>(hours) * 3600.0;
    }
    auto rate = static_cast<float>(clock.rate);
    if (ImGui::SliderFloat("rate", &rate, 0.0F, 10000.0F, "%.0f x", ImGuiSliderFlags_Logarithmic)) {
        clock.rate = static_cast<double>(rate);
    }
}

// The sky's model and the parameters that it reads.
void draw_air(Atmosphere& air) {
    const auto chosen = static_cast<std::size_t>(air.model);
    if (ImGui::BeginCombo("sky", sky_model_names[chosen].data())) {
        for (std::size_t i = 0; i < sky_model_names.size(); ++i) {
            if (ImGui::Selectable(sky_model_names[i].data(), i == chosen)) {
                air.model = static_cast<SkyModel>(i);
            }
        }
        ImGui::EndCombo();
    }
    ImGui::SliderFloat("turbidity", &air.turbidity, 1.7F, 10.0F, "%.2f");
    if (air.model == SkyModel::perez || air.model == SkyModel::asrc_cie) {
        ImGui::SliderFloat("clearness", &air.clearness, 1.0F, 12.0F, "%.2f");
    }
    if (air.model == SkyModel::perez) {
        ImGui::SliderFloat("brightness", &air.brightness, 0.01F, 0.6F, "%.3f");
    }
    if (air.model == SkyModel::cie_general) {
        ImGui::SliderInt("CIE type", &air.cie_type, 1, 15);
    }
    if (air.model == SkyModel::scattering) {
        ImGui::SliderFloat("ozone", &air.ozone_atm_cm, 0.0F, 1.0F, "%.2f atm cm");
        ImGui::ColorEdit3("ground", &air.ground_albedo.r, ImGuiColorEditFlags_Float | ImGuiColorEditFlags_NoInputs);
    }
}

void draw_place_and_air(Game& game) {
    Observer& observer = game.observer();
    float place[2] = {static_cast<float>(observer.latitude_rad / degree),
                      static_cast<float>(observer.longitude_rad / degree)};
    if (ImGui::DragFloat2("lat, lon", place, 0.1F, -180.0F, 180.0F, "%.2f")) {
        observer.latitude_rad = std::clamp(static_cast<double>(place[0]), -90.0, 90.0) * degree;
        observer.longitude_rad = std::clamp(static_cast<double>(place[1]), -180.0, 180.0) * degree;
    }
    draw_air(game.atmosphere());
    ImGui::SliderFloat("exposure", &game.exposure_bias_ev, -6.0F, 6.0F, "%+.1f EV");
}

void draw_reports(const std::vector<SystemReport>& reports) {
    constexpr ImGuiTableFlags flags = ImGuiTableFlags_RowBg | ImGuiTableFlags_SizingStretchProp;
    if (!ImGui::BeginTable("systems", 5, flags)) {
        return;
    }
    for (const char* heading : {"system", "updated", "skipped", "ms", "bound"}) {
        ImGui::TableSetupColumn(heading);
    }
    ImGui::TableHeadersRow();
    for (const SystemReport& report : reports) {
        ImGui::TableNextRow();
        ImGui::TableNextColumn();
        ImGui::TextUnformatted(report.system);
        ImGui::TableNextColumn();
        ImGui::Text("%u", report.updated);
        ImGui::TableNextColumn();
        ImGui::Text("%u", report.skipped);
        ImGui::TableNextColumn();
        ImGui::Text("%.2f", report.cpu_ms);
        ImGui::TableNextColumn();
        ImGui::Text("%.1e", report.error_bound);
    }
    ImGui::EndTable();
}

// Lines of the scene's parts, in ImGui.
class ImGuiPanel final : public PanelWriter {
public:
    explicit ImGuiPanel(std::vector<std::string>& texts) : texts_(texts), kept_(texts.size()) {}

    void text(const std::string& line) override {
        if (next_ >= kept_) {
            texts_.push_back(line);
        }
        ImGui::TextUnformatted(texts_[next_++].c_str());
    }
    bool choice(const char* label, std::span<const char* const> names, int& chosen) override {
        ImGui::TextUnformatted(label);
        const int before = chosen;
        for (int i = 0; i < static_cast<int>(names.size()); ++i) {
            ImGui::SameLine();
            ImGui::PushID(label);
            if (ImGui::RadioButton(names[static_cast<std::size_t>(i)], before == i)) {
                chosen = i;
            }
            ImGui::PopID();
        }
        return chosen != before;
    }
    bool toggle(const char* label, bool& on) override { return ImGui::Checkbox(label, &on); }
    bool slider(const char* label, float& value, float low, float high, bool logarithmic) override {
        return ImGui::SliderFloat(label, &value, low, high, "%.3g", logarithmic ? ImGuiSliderFlags_Logarithmic : 0);
    }
    bool button(const char* label) override { return ImGui::Button(label); }

private:
    std::vector<std::string>& texts_;
    std::size_t kept_; // texts from an earlier frame
    std::size_t next_ = 0;
};

void draw_help() {
    ImGui::SetNextWindowPos(ImVec2(360.0F, 20.0F), ImGuiCond_FirstUseEver);
    ImGui::SetNextWindowSize(ImVec2(330.0F, 0.0F), ImGuiCond_FirstUseEver);
    if (ImGui::Begin("help")) {
        ImGui::TextUnformatted("W A S D        fly\n"
                               "Q E            down, up\n"
                               "Shift          ten times faster\n"
                               "mouse wheel    flying speed\n"
                               "hold a button  look around\n"
                               ", .            slower, faster time\n"
                               "Space          stop and start time\n"
                               "[ ]            an hour back, on\n"
                               "V              charts: sky and its SH, day\n"
                               "T              scene transfer: open, shadows, bounces\n"
                               "PgUp PgDn      next, previous scene\n"
                               "H              hide the panel\n"
                               "F1             this help\n"
                               "F12            screenshot\n"
                               "Esc            leave");
    }
    ImGui::End();
}

} // namespace

void draw_panel(Game& game, PanelState& state) {
    if (state.help) {
        draw_help();
    }
    if (!state.visible) {
        return;
    }
    ImGui::SetNextWindowPos(ImVec2(10.0F, 10.0F), ImGuiCond_FirstUseEver);
    ImGui::SetNextWindowSize(ImVec2(330.0F, 0.0F), ImGuiCond_FirstUseEver);
    if (ImGui::Begin("Alpenglow")) {
        ImGui::Text("%.0f fps   %.1f ms CPU   %s", state.frame_wall_ms > 0.0 ? 1000.0 / state.frame_wall_ms : 0.0,
                    state.frame_cpu_ms, state.device.c_str());
        ImGui::TextUnformatted((show_time(state.utc_j2000_s) + "   F1: help").c_str());
        const CelestialState& bodies = game.celestial();
        ImGui::Text("sun  %6.2f up  %6.2f az   moon %6.2f up  %6.2f az", altitude_deg(bodies.to_sun),
                    azimuth_deg(bodies.to_sun), altitude_deg(bodies.to_moon), azimuth_deg(bodies.to_moon));
        if (!state.scenes.empty()) {
            const auto chosen = static_cast<std::size_t>(state.scene);
            if (ImGui::BeginCombo("scene", state.scenes[chosen].c_str())) {
                for (std::size_t i = 0; i < state.scenes.size(); ++i) {
                    if (ImGui::Selectable(state.scenes[i].c_str(), i == chosen)) {
                        state.scene = static_cast<int>(i);
                        state.scene_chosen = true;
                    }
                }
                ImGui::EndCombo();
            }
        }
        draw_time(game, state.utc_j2000_s);
        draw_place_and_air(game);
        if (!game.parts().empty()) {
            ImGui::Separator();
            ImGuiPanel writer(state.texts);
            for (const std::unique_ptr<Part>& part : game.parts()) {
                part->draw_panel(writer);
            }
        }
        draw_reports(state.reports);
        if (!state.message.empty()) {
            ImGui::TextWrapped("%s", state.message.c_str());
        }
    }
    ImGui::End();
}

} // namespace alpenglow::sandbox
