/// The nearest motion that can be had, where the one that was asked for cannot.
#pragma once
