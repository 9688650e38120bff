/* Image filters as a student might have them lying about. */

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* Pixels at or above the level become white, the others black; gives the number of white ones, or -1. */
int32_t threshold(const uint8_t *image, int32_t width, int32_t height, uint8_t level, uint8_t *out)
{
    int32_t white = 0;
    if (width <= 0 || height <= 0)
        return -1;
    for (int32_t i = 0; i < width * height; i++) {
        out[i] = image[i] >= level ? 255 : 0;
        white += image[i] >= level;
    }
    return white;
}

double mean(const uint8_t *image, int32_t width, int32_t height)
{
    double sum = 0.0;
    for (int32_t i = 0; i < width * height; i++)
        sum += image[i];
    return sum / (width * height); /* not a number for a picture without pixels */
}

int32_t length_of(const char *text) { return (int32_t)strlen(text); }

void crash(void) { abort(); }
