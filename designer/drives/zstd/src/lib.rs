//! The part of the crate `zstd` that `parquet` calls, on `ruzstd` in place of the C library: Parquet files
//! with zstd are read with nothing but Rust and a linker. ARCHITECTURE.md says why the `[patch]` stays.
//!
//! `stream` and the levels are what `zip` calls beside, of which the tests' foreign importer asks for zstd.
//!
//! Names and behaviour are those of `zstd`; compression has one level, the fastest.

use std::ops::RangeInclusive;

pub use stream::read::Decoder;

/// Level that is taken where none is asked for.
pub const DEFAULT_COMPRESSION_LEVEL: i32 = 3;

/// Levels that may be asked for.
pub const fn compression_level_range() -> RangeInclusive<i32> {
    -131_072..=22
}

/// Whole buffers at once.
pub mod bulk {
    use std::io::{self, Cursor};
    use std::marker::PhantomData;

    use ruzstd::decoding::FrameDecoder;
    use ruzstd::encoding::{CompressionLevel, compress_to_vec};

    /// Compresses buffers.
    #[derive(Debug)]
    pub struct Compressor<'a>(PhantomData<&'a ()>);

    impl Compressor<'_> {
        /// Of any level: all are the same.
        ///
        /// # Errors
        /// None.
        pub fn new(_level: i32) -> io::Result<Self> {
            Ok(Self(PhantomData))
        }

        /// Compresses `source` to where the cursor stands, and returns the number of bytes written.
        ///
        /// # Errors
        /// None: the destination grows.
        pub fn compress_to_buffer(
            &mut self,
            source: &[u8],
            destination: &mut Cursor<&mut Vec<u8>>,
        ) -> io::Result<usize> {
            let compressed = compress_to_vec(source, CompressionLevel::Fastest);
            io::Write::write_all(destination, &compressed)?;
            Ok(compressed.len())
        }
    }

    /// Decompresses buffers.
    pub struct Decompressor<'a>(FrameDecoder, PhantomData<&'a ()>);

    impl Decompressor<'_> {
        /// A new one.
        ///
        /// # Errors
        /// None.
        pub fn new() -> io::Result<Self> {
            Ok(Self(FrameDecoder::new(), PhantomData))
        }

        /// Decompresses `source` to where the cursor stands, and returns the number of bytes written: no more
        /// than the destination has room for.
        ///
        /// # Errors
        /// What is wrong with the source, or that it has more.
        pub fn decompress_to_buffer(
            &mut self,
            source: &[u8],
            destination: &mut Cursor<&mut Vec<u8>>,
        ) -> io::Result<usize> {
            let begin = usize::try_from(destination.position()).map_err(io::Error::other)?;
            let buffer = &mut **destination.get_mut();
            buffer.resize(buffer.capacity().max(begin), 0);
            let written = self.0.decode_all(source, &mut buffer[begin..]);
            buffer.truncate(begin + written.as_ref().copied().unwrap_or(0));
            let written = written.map_err(io::Error::other)?;
            destination.set_position((begin + written) as u64);
            Ok(written)
        }
    }
}

/// Streams.
pub mod stream {
    /// Reading.
    pub mod read {
        use std::io::{self, BufRead, Read};
        use std::marker::PhantomData;

        use ruzstd::decoding::{BlockDecodingStrategy, FrameDecoder};

        /// Decompresses one frame of a reader.
        pub struct Decoder<'a, R> {
            reader: R,
            decoder: FrameDecoder,
            began: bool,
            lifetime: PhantomData<&'a ()>,
        }

        impl<R: BufRead> Decoder<'_, R> {
            /// Of a `reader`, of which nothing is read yet.
            ///
            /// # Errors
            /// None.
            pub fn try_with_buffer(reader: R) -> Result<Self, (R, io::Error)> {
                let decoder = FrameDecoder::new();
                Ok(Self { reader, decoder, began: false, lifetime: PhantomData })
            }
        }

        impl<R> Decoder<'_, R> {
            /// What is read from.
            pub const fn get_ref(&self) -> &R {
                &self.reader
            }

            /// What is read from, back.
            pub fn finish(self) -> R {
                self.reader
            }
        }

        impl<R: BufRead> Read for Decoder<'_, R> {
            fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
                if !self.began {
                    self.decoder.init(&mut self.reader).map_err(io::Error::other)?;
                    self.began = true;
                }
                while self.decoder.can_collect() < buffer.len() && !self.decoder.is_finished() {
                    let missing = buffer.len() - self.decoder.can_collect();
                    let until = BlockDecodingStrategy::UptoBytes(missing);
                    self.decoder
                        .decode_blocks(&mut self.reader, until)
                        .map_err(io::Error::other)?;
                }
                self.decoder.read(buffer)
            }
        }
    }

    /// Writing.
    pub mod write {
        use std::io::{self, Write};
        use std::marker::PhantomData;

        use ruzstd::encoding::{CompressionLevel, compress_to_vec};

        /// Compresses what is written to one frame, at the end.
        pub struct Encoder<'a, W> {
            writer: W,
            written: Vec<u8>,
            lifetime: PhantomData<&'a ()>,
        }

        impl<W: Write> Encoder<'_, W> {
            /// To a `writer`, of any level: all are the same.
            ///
            /// # Errors
            /// None.
            pub fn new(writer: W, _level: i32) -> io::Result<Self> {
                Ok(Self { writer, written: Vec::new(), lifetime: PhantomData })
            }

            /// What is written to.
            pub const fn get_ref(&self) -> &W {
                &self.writer
            }

            /// What is written to.
            pub const fn get_mut(&mut self) -> &mut W {
                &mut self.writer
            }

            /// Writes the frame, and gives the writer back.
            ///
            /// # Errors
            /// Those of the writer.
            pub fn finish(mut self) -> io::Result<W> {
                let frame = compress_to_vec(&self.written[..], CompressionLevel::Fastest);
                self.writer.write_all(&frame)?;
                Ok(self.writer)
            }
        }

        impl<W> Write for Encoder<'_, W> {
            fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
                self.written.extend_from_slice(bytes);
                Ok(bytes.len())
            }

            fn flush(&mut self) -> io::Result<()> {
                Ok(())
            }
        }
    }
}

/// What a frame says of itself.
pub mod zstd_safe {
    use ruzstd::decoding::FrameDecoder;

    /// Bytes of the content of the frame in `source`; `None` where it does not say.
    ///
    /// # Errors
    /// That there is no frame.
    pub fn get_frame_content_size(source: &[u8]) -> Result<Option<u64>, String> {
        let mut decoder = FrameDecoder::new();
        decoder.init(source).map_err(|error| error.to_string())?;
        Ok(Some(decoder.content_size()).filter(|&size| size > 0))
    }

    /// Most bytes that `length` bytes may be compressed to: what cannot be compressed is stored in blocks of
    /// 128 kB with a header each.
    pub const fn compress_bound(length: usize) -> usize {
        length + length / 1024 + 64
    }
}

#[cfg(test)]
mod tests {
    use std::io::{Cursor, Read as _, Write as _};

    use crate::{Decoder, bulk, stream, zstd_safe};

    /// "steerguard " twenty times, by the C library at level 3.
    const BY_C: &[u8] = &[
        0x28, 0xb5, 0x2f, 0xfd, 0x20, 0xdc, 0x95, 0x00, 0x00, 0x58, 0x73, 0x74, 0x65, 0x65, 0x72,
        0x67, 0x75, 0x61, 0x72, 0x64, 0x20, 0x01, 0x00, 0x4e, 0x53, 0xc5, 0x0b,
    ];

    #[test]
    fn what_is_compressed_comes_back_behind_what_was_there() {
        let source: Vec<u8> = (0..200_000_u32).map(|k| (k.wrapping_mul(k) / 977) as u8).collect();
        let mut compressed = Vec::new();
        let mut compressor = bulk::Compressor::new(1).unwrap();
        compressor.compress_to_buffer(&source, &mut Cursor::new(&mut compressed)).unwrap();
        assert!(compressed.len() <= zstd_safe::compress_bound(source.len()));
        let mut found = b"before".to_vec();
        found.reserve_exact(source.len());
        let mut cursor = Cursor::new(&mut found);
        cursor.set_position(6);
        let mut decompressor = bulk::Decompressor::new().unwrap();
        let written = decompressor.decompress_to_buffer(&compressed, &mut cursor).unwrap();
        assert_eq!((written, cursor.position()), (source.len(), 6 + source.len() as u64));
        assert_eq!(&found[..6], b"before");
        assert!(found[6..] == source);

        let mut damaged = compressed.clone();
        damaged.truncate(compressed.len() / 2);
        let mut cursor = Cursor::new(&mut found);
        assert!(decompressor.decompress_to_buffer(&damaged, &mut cursor).is_err());
        assert!(zstd_safe::get_frame_content_size(b"no frame").is_err());
    }

    #[test]
    fn streams_come_back_piece_by_piece() {
        let source: Vec<u8> = (0..300_000_u32).map(|k| (k.wrapping_mul(k) / 977) as u8).collect();
        let mut encoder = stream::write::Encoder::new(Vec::new(), 3).unwrap();
        source.chunks(1000).for_each(|piece| encoder.write_all(piece).unwrap());
        let mut frame = encoder.finish().unwrap();
        let length = frame.len();
        frame.extend(b"behind");
        let mut decoder = Decoder::try_with_buffer(&frame[..]).map_err(|(_, error)| error).unwrap();
        let mut found = Vec::new();
        decoder.read_to_end(&mut found).unwrap();
        assert!(found == source);
        assert_eq!(decoder.finish(), b"behind");

        let mut cut =
            Decoder::try_with_buffer(&frame[..length / 2]).map_err(|(_, error)| error).unwrap();
        assert!(cut.read_to_end(&mut found).is_err());
    }

    #[test]
    fn frames_of_the_c_library_are_read() {
        let mut found = Vec::with_capacity(220);
        let mut decompressor = bulk::Decompressor::new().unwrap();
        decompressor.decompress_to_buffer(BY_C, &mut Cursor::new(&mut found)).unwrap();
        assert_eq!(found, b"steerguard ".repeat(20));
        assert_eq!(zstd_safe::get_frame_content_size(BY_C), Ok(Some(220)));
    }
}
