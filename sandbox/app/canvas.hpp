// A small picture painted on the CPU: charts that lie over the frame.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace alpenglow::sandbox {

// RGBA, 8 bits, premultiplied, rows from the top; y grows downwards. What lies outside is left out.
class Canvas {
public:
    Canvas() = default;
    // Filled with that colour (0 .. 1, as the display takes it), covering `alpha` of what is behind.
    Canvas(int width, int height, glm::vec3 colour, float alpha);

    [[nodiscard]] int width() const { return width_; }
    [[nodiscard]] int height() const { return height_; }
    [[nodiscard]] const std::vector<std::byte>& rgba() const { return rgba_; }
    [[nodiscard]] glm::vec3 at(int x, int y) const;

    void set(int x, int y, glm::vec3 colour);
    // Half-open: from (left, top) up to but without (right, bottom). `strength`: how much of what is there it replaces.
    void fill(int left, int top, int right, int bottom, glm::vec3 colour, float strength = 1.0F);
    // Pixels whose middle is within half a width of the line between two points.
    void line(glm::vec2 from, glm::vec2 to, glm::vec3 colour, float width = 1.0F);
    // ASCII, its capitals 7 pixels high, from the upper left corner.
    void text(int x, int y, const std::string& text, glm::vec3 colour);
    [[nodiscard]] static int text_width(const std::string& text);

private:
    int width_ = 0, height_ = 0;
    std::vector<std::byte> rgba_;
};

} // namespace alpenglow::sandbox
