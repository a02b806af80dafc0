// Expected failures as values: files, devices, scenes, dates out of range. Nothing throws across a module's border.
#pragma once

#include <cassert>
#include <string>
#include <utility>
#include <variant>

namespace alpenglow {

// What went wrong, where, and what would have been right.
struct Error {
    std::string what;     // the failure and the offending value: "latitude is 91"
    std::string where;    // file and field, or the function's subject: "scene.json: observer.latitude_deg"
    std::string expected; // what would be right: "a number from -90 to 90"

    // One line for a person: "WHERE: WHAT (expected EXPECTED)"; empty parts are left out.
    [[nodiscard]] std::string message() const {
        std::string text = where.empty() ? what : where + ": " + what;
        if (!expected.empty()) {
            text += " (expected " + expected + ")";
        }
        return text;
    }
};

// A value or an Error. Reading the wrong one is misuse and asserts.
template <class T>
class [[nodiscard]] Result {
public:
    Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}     // NOLINT(google-explicit-constructor)
    Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {} // NOLINT(google-explicit-constructor)

    [[nodiscard]] bool has_value() const noexcept { return state_.index() == 0; }
    explicit operator bool() const noexcept { return has_value(); }

    [[nodiscard]] T& value() & {
        assert(has_value());
        return *std::get_if<0>(&state_);
    }
    [[nodiscard]] const T& value() const& {
        assert(has_value());
        return *std::get_if<0>(&state_);
    }
    [[nodiscard]] T&& value() && {
        assert(has_value());
        return std::move(*std::get_if<0>(&state_));
    }
    [[nodiscard]] const Error& error() const {
        assert(!has_value());
        return *std::get_if<1>(&state_);
    }

    T* operator->() { return &value(); }
    const T* operator->() const { return &value(); }
    T& operator*() & { return value(); }
    const T& operator*() const& { return value(); }

private:
    std::variant<T, Error> state_;
};

// Success without a value.
struct Ok {};
using Status = Result<Ok>;

} // namespace alpenglow
