// The screen-aligned pictures of clouds that the viewer is in (003, section 3.1), used again: keys along the flight,
// each taken for where the viewer is about to be, some rows a frame, and shown bent to its depths. Between two keys one
// takes over from the other.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

#include <alpenglow/impostors/geometry.hpp>
#include <alpenglow/systems/cloud_impostors.hpp>

#include "sandbox/app/impostor_mesh.hpp"

namespace alpenglow::sandbox {

// Where the viewer will be if he goes on as in the last two frames.
class ViewPrediction {
public:
    void see(const impostors::Frustum& view); // once a frame
    [[nodiscard]] impostors::Frustum after(int frames) const;
    [[nodiscard]] double motion_m() const; // a frame

private:
    impostors::Frustum now_;
    glm::dvec3 motion_m_{0.0};
    double turn_ = 0.0, rise_ = 0.0; // rad a frame
};

// Whether a view's window lies within a picture's, but for `slack` times its size.
[[nodiscard]] bool covers(const impostors::Frustum& picture, const impostors::Frustum& view, double slack);

class InsidePictures {
public:
    // Where opaque things cut the cloud: its depth along the view, and what they are to the caller.
    struct Cut {
        double at_m = 0.0;
        std::vector<std::size_t> things;
    };
    struct Slab {
        std::vector<glm::vec4> texels; // premultiplied radiance and alpha
        PictureMesh mesh;
    };
    struct Key {
        impostors::Frustum view;
        std::vector<Cut> cuts;   // from near to far
        std::vector<Slab> slabs; // between them: one more
        glm::ivec2 tile{0};      // the first slab's upper left corner in the atlas; the others follow below
        double content = 0.0;
        float encoded_gain = 0.0F; // the caller's
        bool coarse = false;

        [[nodiscard]] glm::ivec2 tile_of(std::size_t slab) const {
            return {tile.x, tile.y + static_cast<int>(slab) * view.height};
        }
    };
    struct Cloud {
        std::optional<Key> from, to;
        float weight = 1.0F; // of `to`

    private:
        friend class InsidePictures;
        std::optional<CloudCapture> march;
        Key next;
        double units = 0.0, next_units = 0.0; // of work, on the last key that was marched whole and on `next`
        int since = 0;                        // frames since `to` came
        int period = 0;                       // frames from one key to the next
    };
    struct Wanted {
        std::uint64_t object = 0;
        double content = 0.0;
        bool at_once = false; // nothing else shows it
    };
    // A cloud's subject, and what cuts it in a view so many frames from now.
    using Subject = std::function<std::optional<CloudSubject>(std::uint64_t object)>;
    using Cuts = std::function<std::vector<Cut>(std::uint64_t object, const impostors::Frustum& view, int frames)>;

    // Goes on with the pictures of the clouds that are wanted in `view`, for about `units` of work (impostor_work.hpp);
    // returns what was spent. `strip`: the part of the atlas for them, corner and size. `taken`: objects that have a
    // new picture.
    double update(std::span<const Wanted> wanted, const impostors::Frustum& view, const glm::ivec4& strip, double units,
                  const Subject& subject, const Cuts& cuts, std::vector<std::uint64_t>& taken);

    [[nodiscard]] Cloud* find(std::uint64_t object);
    [[nodiscard]] const Cloud* find(std::uint64_t object) const;
    void clear() { clouds_.clear(); }

private:
    [[nodiscard]] std::optional<glm::ivec2> free_tile(const glm::ivec4& strip, const glm::ivec2& size) const;
    [[nodiscard]] bool begin(Cloud& cloud, const Wanted& wanted, const impostors::Frustum& view, int frames,
                             double downscale, const glm::ivec4& strip, const Subject& subject, const Cuts& cuts);
    void finish(Cloud& cloud, std::vector<std::uint64_t>& taken, std::uint64_t object);

    std::map<std::uint64_t, Cloud> clouds_; // in order, for the same bits in every run
    ViewPrediction prediction_;
};

} // namespace alpenglow::sandbox
