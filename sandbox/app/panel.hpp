// The HUD and the panel: frames per second, each system's report, and the things that a player may turn.
#pragma once

#include <string>
#include <vector>

#include "sandbox/app/game.hpp"

namespace alpenglow::sandbox {

// What the panel shows beside the game, and what it asks of the application.
struct PanelState {
    double frame_wall_ms = 0.0;
    double frame_cpu_ms = 0.0;
    std::vector<SystemReport> reports; // of a recent frame: figures that change a few times a second can be read, and
                                       // the panel's picture is kept in between
    double utc_j2000_s = 0.0;          // likewise
    std::vector<std::string> texts;    // likewise: the parts' lines; emptied to be written anew
    std::string device;
    std::string message;             // a shader's error, a screenshot's path; shown until replaced
    std::vector<std::string> scenes; // names to choose from
    int scene = 0;
    bool visible = true;
    bool help = false;
    // Set by the panel, cleared by the application.
    bool scene_chosen = false;
    bool screenshot = false;
};

// Declares the windows of this frame; call between ImGui::NewFrame and ImGui::Render.
void draw_panel(Game& game, PanelState& state);

} // namespace alpenglow::sandbox
