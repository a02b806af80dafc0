#include "reader.hpp"

#include <algorithm>
#include <cmath>

namespace alpenglow::sandbox {

std::string shown(double number) {
    return Json(number).dump();
}

std::string shown(const Json& value) {
    std::string text = value.dump(-1, ' ', false, Json::error_handler_t::replace);
    if (text.size() > 60) {
        text = text.substr(0, 57) + "...";
    }
    return text;
}

const Json* Reader::find(const char* key) {
    known_.emplace_back(key);
    const auto at = object_.find(key);
    return failed_ || at == object_.end() ? nullptr : &*at;
}

const Json* Reader::find_number(const char* key, double low, double high) {
    const Json* value = find(key);
    if (value == nullptr) {
        return nullptr;
    }
    if (!value->is_number() || !(value->get<double>() >= low && value->get<double>() <= high)) {
        fail(key, shown(*value), "a number from " + shown(low) + " to " + shown(high));
        return nullptr;
    }
    return value;
}

void Reader::number(const char* key, double low, double high, double& out) {
    if (const Json* value = find_number(key, low, high)) {
        out = value->get<double>();
    }
}

void Reader::number(const char* key, double low, double high, float& out) {
    if (const Json* value = find_number(key, low, high)) {
        out = value->get<float>();
    }
}

void Reader::number(const char* key, double low, double high, int& out) {
    if (const Json* value = find_number(key, low, high)) {
        const double number = value->get<double>();
        if (number != std::floor(number)) {
            fail(key, shown(*value), "a whole number from " + shown(low) + " to " + shown(high));
            return;
        }
        out = static_cast<int>(number);
    }
}

void Reader::numbers(const char* key, double low, double high, glm::vec3& out) {
    const Json* value = find(key);
    if (value == nullptr) {
        return;
    }
    const std::string expected = "three numbers from " + shown(low) + " to " + shown(high);
    if (!value->is_array() || value->size() != 3) {
        fail(key, shown(*value), expected);
        return;
    }
    for (int k = 0; k < 3; ++k) {
        const Json& item = (*value)[static_cast<std::size_t>(k)];
        if (!item.is_number() || !(item.get<double>() >= low && item.get<double>() <= high)) {
            fail(std::string(key) + "[" + std::to_string(k) + "]", shown(item), expected);
            return;
        }
        out[k] = item.get<float>();
    }
}

void Reader::text(const char* key, std::string& out) {
    const Json* value = find(key);
    if (value == nullptr) {
        return;
    }
    if (!value->is_string() || value->get_ref<const std::string&>().empty()) {
        fail(key, shown(*value), "a text that is not empty");
        return;
    }
    out = value->get<std::string>();
}

void Reader::boolean(const char* key, bool& out) {
    const Json* value = find(key);
    if (value == nullptr) {
        return;
    }
    if (!value->is_boolean()) {
        fail(key, shown(*value), "true or false");
        return;
    }
    out = value->get<bool>();
}

void Reader::name(const char* key, std::span<const std::string_view> names, int& out) {
    const Json* value = find(key);
    if (value == nullptr) {
        return;
    }
    const auto at =
        value->is_string() ? std::find(names.begin(), names.end(), value->get_ref<const std::string&>()) : names.end();
    if (at == names.end()) {
        std::string expected;
        for (std::size_t i = 0; i < names.size(); ++i) {
            expected.append(i == 0 ? "" : i + 1 == names.size() ? " or " : ", ").append(names[i]);
        }
        fail(key, shown(*value), expected);
        return;
    }
    out = static_cast<int>(at - names.begin());
}

const Json* Reader::object(const char* key) {
    const Json* value = find(key);
    if (value != nullptr && !value->is_object()) {
        fail(key, shown(*value), "an object");
        return nullptr;
    }
    return value;
}

void Reader::each(const char* key, const std::function<void(Reader& item)>& read) {
    const Json* value = find(key);
    if (value == nullptr) {
        return;
    }
    if (!value->is_array()) {
        fail(key, shown(*value), "an array of objects");
        return;
    }
    for (std::size_t i = 0; i < value->size() && !failed_; ++i) {
        const std::string name = std::string(key) + "[" + std::to_string(i) + "]";
        if (!(*value)[i].is_object()) {
            fail(name, shown((*value)[i]), "an object");
            return;
        }
        Reader item((*value)[i], file_, prefix_ + name + ".");
        read(item);
        if (item.failed()) {
            failed_ = true;
            error_ = item.error();
        }
    }
}

void Reader::require(const char* key) {
    if (!failed_ && !object_.contains(key)) {
        failed_ = true;
        error_ = {"is missing", where(key), "it must be given"};
    }
}

void Reader::no_others() {
    for (const auto& member : object_.items()) {
        if (!failed_ && std::find(known_.begin(), known_.end(), member.key()) == known_.end()) {
            std::string names;
            for (const std::string& name : known_) {
                names += (names.empty() ? "" : ", ") + name;
            }
            const std::string quoted = shown(Json(member.key()));
            failed_ = true;
            error_ = {"unknown field", where(quoted.substr(1, quoted.size() - 2)), "one of " + names};
        }
    }
}

void Reader::fail(const std::string& key, const std::string& value, const std::string& expected) {
    if (!failed_) {
        failed_ = true;
        error_ = {"is " + value, where(key), expected};
    }
}

} // namespace alpenglow::sandbox
