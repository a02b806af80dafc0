#include "sandbox/app/cloud_tables.hpp"

#include <algorithm>

#include <alpenglow/clouds/shader_tables.hpp>

#include "sandbox/world/render_data.hpp"

namespace alpenglow::sandbox {
namespace {

constexpr std::size_t view_header = 16; // words of pack_view() ahead of the fields

} // namespace

template <class Pack>
CloudTables::Kept& CloudTables::keep(const void* of, std::uint32_t content_revision, Pack pack) {
    const auto known = std::find_if(kept_.begin(), kept_.end(), [&](const Kept& kept) {
        return kept.of == of && kept.content_revision == content_revision;
    });
    if (known != kept_.end()) {
        known->used = true;
        return *known;
    }
    Kept made;
    made.of = of;
    made.content_revision = content_revision;
    made.words = pack();
    made.revision = next_revision();
    made.used = true;
    kept_.push_back(std::move(made));
    return kept_.back();
}

void CloudTables::update(std::span<const MarchedCloud> clouds, const clouds::Camera& camera,
                         const clouds::MarchSettings& settings) {
    if (detail_revision_ == 0) {
        detail_ = settings.detail != nullptr ? clouds::pack_detail(*settings.detail) : std::vector<std::uint32_t>(1);
        detail_revision_ = next_revision();
    }
    for (Kept& kept : kept_) {
        kept.used = false;
    }
    // Numbers are given once it is known what is still used.
    struct Three {
        const void* of[3];
        std::uint32_t revision[3];
    };
    std::vector<Three> wanted;
    for (const MarchedCloud& item : clouds) {
        const clouds::BrickVolume& volume = *item.cloud.volume;
        const clouds::CloudLighting& lighting = *item.cloud.lighting;
        keep(&volume, 0, [&] { return clouds::pack_volume(volume); });
        keep(&lighting, item.light_revision, [&] { return clouds::pack_light(volume, lighting); });
        Kept& view = keep(item.fields, item.fields_revision,
                          [&] { return clouds::pack_view(volume, lighting, *item.fields, settings); });
        // What changes with neither light nor eye: step and detail.
        const std::vector<std::uint32_t> header = clouds::pack_view(volume, lighting, {}, settings);
        std::copy(header.begin() + 1, header.begin() + view_header, view.words.begin() + 1);
        wanted.push_back({{&volume, &lighting, item.fields}, {0, item.light_revision, item.fields_revision}});
    }
    std::erase_if(kept_, [](const Kept& kept) { return !kept.used; });
    march_.tables = {{detail_, 0, detail_revision_}};
    for (Kept& kept : kept_) {
        kept.number = static_cast<std::uint32_t>(march_.tables.size());
        march_.tables.push_back({kept.words, 0, kept.revision});
    }
    march_.clouds.clear();
    march_.tan_half_height = camera.tan_half_height;
    for (std::size_t i = 0; i < clouds.size(); ++i) {
        const auto number = [&](std::size_t part) {
            return std::find_if(kept_.begin(), kept_.end(),
                                [&](const Kept& kept) {
                                    return kept.of == wanted[i].of[part] &&
                                           kept.content_revision == wanted[i].revision[part];
                                })
                ->number;
        };
        const clouds::BrickVolume& volume = *clouds[i].cloud.volume;
        const clouds::GridTransform& transform = volume.transform();
        const auto local = [&](const glm::vec3& v) { return glm::vec3(transform.local_direction(glm::dvec3(v))); };
        CloudPlace place;
        place.volume = number(0);
        place.light = number(1);
        place.view = number(2);
        march_.tables[place.view].header = view_header;
        place.eye = clouds::shader_eye(volume, camera.position_m - clouds[i].cloud.offset_m);
        place.forward = local(camera.forward);
        place.right = local(camera.right);
        place.up = local(camera.up);
        place.voxel_m = glm::vec3(transform.voxel_m);
        march_.clouds.push_back(place);
    }
}

std::size_t CloudTables::bytes() const {
    std::size_t words = 0;
    for (const CloudTable& table : march_.tables) {
        words += table.words.size();
    }
    return 4 * words;
}

} // namespace alpenglow::sandbox
