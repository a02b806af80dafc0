#include "sandbox/app/impostor_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <glm/geometric.hpp>

namespace alpenglow::sandbox {
namespace {

// Nodes stand at every kMeshCell texels, and at the middles of the picture's outermost texels.
int nodes(int texels) {
    return (texels + kMeshCell - 1) / kMeshCell + 1;
}
float node_at(int i, int texels) {
    return std::clamp(static_cast<float>(i * kMeshCell), 0.5F, static_cast<float>(texels) - 0.5F);
}

// Nodes from a depth for each, and the cells in which `seen` finds anything.
// open_edges: the mesh reaches to the picture's border, where its last texels are held.
template <class Depth, class Seen>
PictureMesh make_mesh(const impostors::Frustum& view, const glm::dvec3& origin_m, bool open_edges, Depth depth,
                      Seen seen) {
    PictureMesh mesh;
    mesh.origin_m = origin_m;
    mesh.across = nodes(view.width);
    const int down = nodes(view.height);
    for (int j = 0; j < down; ++j) {
        for (int i = 0; i < mesh.across; ++i) {
            const glm::vec2 texel(node_at(i, view.width), node_at(j, view.height));
            const double x = open_edges ? std::min(i * kMeshCell, view.width) : static_cast<double>(texel.x);
            const double y = open_edges ? std::min(j * kMeshCell, view.height) : static_cast<double>(texel.y);
            const glm::dvec3 ray = view.direction(x, y);
            mesh.places.emplace_back(view.eye_m + depth(i, j) * ray - origin_m);
            mesh.texels.push_back(texel);
        }
    }
    for (int j = 0; j + 1 < down; ++j) {
        for (int i = 0; i + 1 < mesh.across; ++i) {
            bool any = false;
            for (int y = std::max(0, j * kMeshCell - 1); !any && y < std::min(view.height, (j + 1) * kMeshCell + 1);
                 ++y) {
                for (int x = std::max(0, i * kMeshCell - 1); !any && x < std::min(view.width, (i + 1) * kMeshCell + 1);
                     ++x) {
                    any = seen(static_cast<std::size_t>(y * view.width + x));
                }
            }
            if (any) {
                mesh.cells.push_back(static_cast<std::uint16_t>(j * mesh.across + i));
            }
        }
    }
    return mesh;
}

} // namespace

PictureMesh picture_mesh(const impostors::Capture& capture, std::size_t layer_index, const glm::dvec3& origin_m) {
    const impostors::Layer& layer = capture.layers[layer_index];
    const impostors::MipLevel& base = layer.mips.front();
    const auto depth = [&](int i, int j) {
        if (layer.warp.empty()) {
            return layer.plane_m;
        }
        // Between the texels around the node.
        const float u = std::clamp(static_cast<float>(i * kMeshCell) - 0.5F, 0.0F, static_cast<float>(base.width - 1));
        const float v = std::clamp(static_cast<float>(j * kMeshCell) - 0.5F, 0.0F, static_cast<float>(base.height - 1));
        const int x = std::min(static_cast<int>(u), std::max(0, base.width - 2));
        const int y = std::min(static_cast<int>(v), std::max(0, base.height - 2));
        const auto at = [&](int a, int b) {
            return layer.warp[static_cast<std::size_t>(std::min(b, base.height - 1) * base.width +
                                                       std::min(a, base.width - 1))];
        };
        const float s = u - static_cast<float>(x);
        const float t = v - static_cast<float>(y);
        const float w = (1.0F - t) * ((1.0F - s) * at(x, y) + s * at(x + 1, y)) +
                        t * ((1.0F - s) * at(x, y + 1) + s * at(x + 1, y + 1));
        return std::clamp(capture.depth_origin_m + capture.depth_scale_m * static_cast<double>(w),
                          std::max(layer.near_m, 1e-3 * layer.far_m), layer.far_m);
    };
    return make_mesh(capture.view, origin_m, capture.open_edges, depth,
                     [&](std::size_t i) { return base.colour[i].w > 0.002F; });
}

PictureMesh picture_mesh(const clouds::Picture& picture, const impostors::Frustum& view) {
    const int across = nodes(view.width);
    const int down = nodes(view.height);
    constexpr float none = 1e9F;
    // The least axis depth of each cell, then of the four around each node.
    const auto cells_across = static_cast<std::size_t>(across - 1);
    std::vector<float> least(cells_across * static_cast<std::size_t>(down - 1), none);
    for (int y = 0; y < view.height; ++y) {
        for (int x = 0; x < view.width; ++x) {
            const auto i = static_cast<std::size_t>(y * view.width + x);
            if (picture.transmittance[i] < 0.98F && picture.depth_m[i] > 0.0F) {
                const auto length = static_cast<float>(glm::length(view.direction(x + 0.5, y + 0.5)));
                float& cell = least[static_cast<std::size_t>(y / kMeshCell) * cells_across +
                                    static_cast<std::size_t>(x / kMeshCell)];
                cell = std::min(cell, picture.depth_m[i] / length);
            }
        }
    }
    const auto depth = [&](int i, int j) {
        float z = none;
        for (int b = std::max(0, j - 1); b <= std::min(j, down - 2); ++b) {
            for (int a = std::max(0, i - 1); a <= std::min(i, across - 2); ++a) {
                z = std::min(z, least[static_cast<std::size_t>(b) * cells_across + static_cast<std::size_t>(a)]);
            }
        }
        return z < none ? static_cast<double>(z) : 20000.0;
    };
    return make_mesh(view, view.eye_m, true, depth, [&](std::size_t i) { return picture.transmittance[i] < 0.998F; });
}

PictureMesh mean_depth_mesh(const clouds::Picture& picture, const impostors::Frustum& view, double least_m) {
    const int across = nodes(view.width);
    const int down = nodes(view.height);
    const auto cells_across = static_cast<std::size_t>(across - 1);
    const std::size_t cells = cells_across * static_cast<std::size_t>(down - 1);
    // Inverse depths by cell, weighted by what is seen; then of the four cells around each node.
    std::vector<glm::dvec2> sum(cells, glm::dvec2(0.0));
    for (int y = 0; y < view.height; ++y) {
        for (int x = 0; x < view.width; ++x) {
            const auto i = static_cast<std::size_t>(y * view.width + x);
            const auto alpha = static_cast<double>(1.0F - picture.transmittance[i]);
            if (alpha > 0.0 && picture.depth_m[i] > 0.0F) {
                const double z =
                    static_cast<double>(picture.depth_m[i]) / glm::length(view.direction(x + 0.5, y + 0.5));
                sum[static_cast<std::size_t>(y / kMeshCell) * cells_across + static_cast<std::size_t>(x / kMeshCell)] +=
                    glm::dvec2(alpha / std::max(z, 2.0), alpha);
            }
        }
    }
    glm::dvec2 whole(1e-9 / 500.0, 1e-9);
    for (const glm::dvec2& cell : sum) {
        whole += cell;
    }
    const auto depth = [&](int i, int j) {
        glm::dvec2 near = 1e-3 * whole / whole.y; // where nothing is, as the rest
        for (int b = std::max(0, j - 1); b <= std::min(j, down - 2); ++b) {
            for (int a = std::max(0, i - 1); a <= std::min(i, across - 2); ++a) {
                near += sum[static_cast<std::size_t>(b) * cells_across + static_cast<std::size_t>(a)];
            }
        }
        return std::max(near.y / near.x, least_m);
    };
    return make_mesh(view, view.eye_m, true, depth, [&](std::size_t i) { return picture.transmittance[i] < 0.998F; });
}

glm::vec2 texel_in(const impostors::Frustum& view, const glm::dvec3& place_m) {
    const glm::dvec3 v = place_m - view.eye_m;
    const double z = std::max(glm::dot(v, view.forward), 1e-6 * glm::length(v));
    const double x = (glm::dot(v, view.right) / z - view.tan_left) * view.pixels_per_tan_x();
    const double y = (view.tan_top - glm::dot(v, view.up) / z) * view.pixels_per_tan_y();
    return {static_cast<float>(std::clamp(x, 0.5, view.width - 0.5)),
            static_cast<float>(std::clamp(y, 0.5, view.height - 0.5))};
}

void MeshBuilder::clear() {
    vertices_.clear();
    indices_.clear();
    runs_.clear();
}

void MeshBuilder::add(const PictureMesh& mesh, const glm::vec2& tile, float weight, const Fade& fade,
                      const DepthPart* part) {
    if (mesh.cells.empty() || !(weight > 0.0F)) {
        return;
    }
    const bool divided = part != nullptr && part->share < 1.0F;
    const bool fading = !divided && fade.before != nullptr;
    // A picture that comes in on its own is drawn as one that fades with nothing: its weight counts there.
    const ImpostorRun::Kind kind = divided                   ? ImpostorRun::divided
                                   : fading || weight < 1.0F ? ImpostorRun::fading
                                                             : ImpostorRun::plain;
    const auto first = static_cast<std::uint32_t>(vertices_.size());
    for (std::size_t n = 0; n < mesh.places.size(); ++n) {
        glm::dvec3 place = mesh.origin_m + glm::dvec3(mesh.places[n]);
        ImpostorVertex vertex;
        vertex.texel = tile + mesh.texels[n];
        vertex.before = vertex.texel;
        vertex.weights = {weight, 0.0F};
        if (fading) {
            vertex.before = fade.before_tile + texel_in(*fade.before, place);
            vertex.weights = weight * glm::vec2(fade.weight, 1.0F - fade.weight);
        }
        if (part != nullptr) {
            const glm::dvec3 v = place - part->eye_m;
            const double z = glm::dot(v, part->forward);
            if (z > 0.01 * glm::length(v)) { // what lies beside the eye is not seen
                place = part->eye_m + v * (std::clamp(z, part->near_m, part->far_m) / z);
            }
            vertex.share = part->share;
        }
        vertex.position_m = glm::vec3(place);
        vertices_.push_back(vertex);
    }
    const auto begin = static_cast<std::uint32_t>(indices_.size());
    const auto row = static_cast<std::uint32_t>(mesh.across);
    for (const std::uint16_t cell : mesh.cells) {
        const std::uint32_t a = first + cell;
        indices_.insert(indices_.end(), {a, a + row, a + 1, a + 1, a + row, a + row + 1});
    }
    const auto count = static_cast<std::uint32_t>(indices_.size()) - begin;
    if (!runs_.empty() && runs_.back().kind == kind) {
        runs_.back().index_count += count;
    } else {
        runs_.push_back({begin, count, kind});
    }
}

} // namespace alpenglow::sandbox
